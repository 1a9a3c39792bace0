// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using System.Text;

namespace Tandem {

/// <summary>A transport of the program's. It is called only during calls of a peer or a session, on
/// their thread, and must not call back into them. Its exceptions leave that call.</summary>
public interface ITransport {
  /// <summary>This peer; unique in the session, never 0.</summary>
  ulong Self { get; }
  /// <summary>Bytes of the longest packet that it accepts: 512 to 61440; 0 is 61440.</summary>
  int MaxPacket { get; }
  /// <summary>Must not block, and must copy what it keeps: the buffer is reused.</summary>
  /// <returns>whether it accepted the first `size` bytes</returns>
  bool Post(ulong to, byte[] packet, int size, Delivery delivery);
  /// <summary>Gives each packet received since the last call to the inbox, as it was
  /// posted.</summary>
  void Drain(Inbox inbox);
  /// <summary>Adds each peer ever seen, by ascending id.</summary>
  void ListPeers(PeerList list);
  /// <summary>Disconnect a peer that sends undecodable packets.</summary>
  void Drop(ulong peer, string reason);
}

/// <summary>Valid during the call of ITransport.Drain that receives it.</summary>
public unsafe struct Inbox {
  private readonly ReceiveFunction receive;
  private readonly IntPtr inbox;

  internal Inbox(ReceiveFunction receive, IntPtr inbox) {
    this.receive = receive;
    this.inbox = inbox;
  }

  public void Receive(ulong from, byte[] packet, int size) {
    Native.CheckCount(nameof(size), size, packet);
    fixed (byte* bytes = packet) receive(inbox, from, bytes, (UIntPtr)size);
  }
}

/// <summary>Valid during the call of ITransport.ListPeers that receives it.</summary>
public struct PeerList {
  private readonly ListPeerFunction list;
  private readonly IntPtr into;

  internal PeerList(ListPeerFunction list, IntPtr into) {
    this.list = list;
    this.into = into;
  }

  public void Add(ulong peer, bool connected) => list(into, peer, connected ? 1 : 0);
}

/// <summary>Carries bytes between peers: of a Network, of a Channel, or the program's.</summary>
public sealed unsafe class Transport : IDisposable {
  internal readonly TransportHandle Handle = new TransportHandle();
  /// <summary>The calls into the program; null for a network's.</summary>
  internal readonly TransportCalls Calls;
  /// <summary>Dependents of it and of its parents, as World.Dependents.</summary>
  internal readonly List<object> Dependents;

  public Transport(ITransport transport) {
    if (transport == null) throw new ArgumentNullException(nameof(transport));
    Calls = new TransportCalls(transport);
    Dependents = new List<object>();
    // Weak: the handle keeps it alive, and is freed when it is unreachable.
    var user = GCHandle.Alloc(Calls, GCHandleType.Weak);
    var def = Calls.Def(GCHandle.ToIntPtr(user));
    NativeError error;
    var made = Native.tandem_transport_create(&def, &error);
    if (made == IntPtr.Zero) user.Free();
    Handle.Adopt(made, ref error);
    Handle.User = user;
    Handle.Calls = Calls;
  }

  /// <summary>A transport that the parent owns.</summary>
  internal Transport(IntPtr made, ref NativeError error, SafeHandle parent, TransportCalls calls,
                     List<object> dependents) {
    Handle.Adopt(made, ref error, parent);
    Calls = calls;
    Dependents = dependents;
  }

  /// <summary>It is freed after everything that runs on it.</summary>
  public void Dispose() => Handle.Dispose();
}

/// <summary>The library's calls into a transport of the program's.</summary>
internal sealed unsafe class TransportCalls {
  // Never collected, as the library has their addresses.
  private static readonly PostFunction postFunction = Post;
  private static readonly DrainFunction drainFunction = Drain;
  private static readonly PeersFunction peersFunction = ListPeers;
  private static readonly DropFunction dropFunction = Drop;

  private readonly ITransport transport;
  private byte[] packet = new byte[2048];
  private Exception failure;
  // The library's functions, the same in each call.
  private IntPtr receivePointer, listPointer;
  private ReceiveFunction receive;
  private ListPeerFunction list;

  internal TransportCalls(ITransport transport) {
    this.transport = transport;
  }

  internal NativeTransportDef Def(IntPtr user) => new NativeTransportDef {
      User = user,
      Self = transport.Self,
      Post = Marshal.GetFunctionPointerForDelegate(postFunction),
      Drain = Marshal.GetFunctionPointerForDelegate(drainFunction),
      Peers = Marshal.GetFunctionPointerForDelegate(peersFunction),
      Drop = Marshal.GetFunctionPointerForDelegate(dropFunction),
      MaxPacket = (UIntPtr)transport.MaxPacket};

  /// <summary>Call after each call of the library that may have called the transport.</summary>
  internal void Rethrow() {
    if (failure == null) return;
    var thrown = failure;
    failure = null;
    throw new InvalidOperationException("a transport has thrown", thrown);
  }

  private static TransportCalls Of(IntPtr user) =>
      GCHandle.FromIntPtr(user).Target as TransportCalls;

  [MonoPInvokeCallback(typeof(PostFunction))]
  private static int Post(IntPtr user, ulong to, byte* bytes, UIntPtr size, Delivery delivery) {
    var calls = Of(user);
    if (calls == null) return 0;  // the collector is freeing all of it
    try {
      var count = (int)size;
      if (count > calls.packet.Length) calls.packet = new byte[2 * count];
      if (count > 0) Marshal.Copy((IntPtr)bytes, calls.packet, 0, count);
      return calls.transport.Post(to, calls.packet, count, delivery) ? 1 : 0;
    } catch (Exception thrown) {
      calls.failure = thrown;  // exceptions must not pass through the library
      return 0;
    }
  }

  [MonoPInvokeCallback(typeof(DrainFunction))]
  private static void Drain(IntPtr user, IntPtr receive, IntPtr inbox) {
    var calls = Of(user);
    if (calls == null) return;
    try {
      if (calls.receivePointer != receive) {
        calls.receive = Marshal.GetDelegateForFunctionPointer<ReceiveFunction>(receive);
        calls.receivePointer = receive;
      }
      calls.transport.Drain(new Inbox(calls.receive, inbox));
    } catch (Exception thrown) {
      calls.failure = thrown;
    }
  }

  [MonoPInvokeCallback(typeof(PeersFunction))]
  private static void ListPeers(IntPtr user, IntPtr list, IntPtr into) {
    var calls = Of(user);
    if (calls == null) return;
    try {
      if (calls.listPointer != list) {
        calls.list = Marshal.GetDelegateForFunctionPointer<ListPeerFunction>(list);
        calls.listPointer = list;
      }
      calls.transport.ListPeers(new PeerList(calls.list, into));
    } catch (Exception thrown) {
      calls.failure = thrown;
    }
  }

  [MonoPInvokeCallback(typeof(DropFunction))]
  private static void Drop(IntPtr user, ulong peer, byte* reason) {
    var calls = Of(user);
    if (calls == null) return;
    try {
      var length = 0;
      while (reason != null && reason[length] != 0) ++length;
      calls.transport.Drop(peer, length == 0 ? "" : Encoding.UTF8.GetString(reason, length));
    } catch (Exception thrown) {
      calls.failure = thrown;
    }
  }
}

}  // namespace Tandem
