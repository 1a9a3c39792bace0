// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Collections.Generic;

namespace Tandem {

/// <summary>Links between peers of one process, in virtual time: for tests.</summary>
public sealed unsafe class Network : IDisposable {
  private readonly NetworkHandle handle = new NetworkHandle();
  private readonly List<object> dependents = new List<object>();
  private readonly List<Transport> transports = new List<Transport>();

  /// <param name="startNs">session time, above 0</param>
  public Network(Link link, ulong seed = 1, long startNs = 1000000000) {
    NativeError error;
    handle.Adopt(Native.tandem_network_create(&link, seed, startNs, &error), ref error);
  }

  /// <summary>It is freed after all peers on it.</summary>
  public void Dispose() {
    foreach (var transport in transports) transport.Dispose();
    handle.Dispose();
  }

  /// <summary>The transport of one peer, which has only one. It is freed with the
  /// network.</summary>
  public Transport Transport(ulong peer) {
    NativeError error;
    var made = Native.tandem_network_transport(handle, peer, &error);
    var transport = new Transport(made, ref error, handle, null, dependents);
    transports.Add(transport);
    return transport;
  }

  /// <summary>Deliver packets that are due.</summary>
  /// <param name="timeNs">never decreases</param>
  public void Advance(long timeNs) {
    NativeError error;
    Native.Check(Native.tandem_network_advance(handle, timeNs, &error), ref error);
  }
}

/// <summary>A message of another peer's application. Untrusted.</summary>
public struct Message {
  public ulong From;
  public long StampNs;  // session time at which it was sent
  public string Topic;
  public byte[] Payload;
}

/// <summary>Messages between peers, by topic: each arrives once, those of a sender in order,
/// despite losses and broken connections. All members of a session use a channel, or none does. A
/// Session has its own.</summary>
public sealed unsafe class Channel : IDisposable {
  private readonly ChannelHandle handle = new ChannelHandle();
  private readonly Transport below;
  private NativeEvent[] events = new NativeEvent[8];

  /// <summary>The transport to give to the peer.</summary>
  public Transport Transport { get; }

  public Channel(Transport transport) {
    below = transport ?? throw new ArgumentNullException(nameof(transport));
    NativeError error;
    handle.Adopt(Native.tandem_channel_create(transport.Handle, &error), ref error,
                 transport.Handle);
    Transport = new Transport(Native.tandem_channel_transport(handle), ref error, handle,
                              transport.Calls, transport.Dependents);
    transport.Dependents.Add(this);
  }

  /// <summary>It is freed after its peer.</summary>
  public void Dispose() {
    Transport.Dispose();
    handle.Dispose();
    below.Dependents.Remove(this);
  }

  /// <summary>Call before each Peer.BeforeStep.</summary>
  public void Poll(long nowNs) {
    NativeError error;
    var result = Native.tandem_channel_poll(handle, nowNs, &error);
    below.Calls?.Rethrow();
    Native.Check(result, ref error);
  }

  /// <summary>Stamped with the time of the last poll.</summary>
  /// <param name="topic">at most 64 bytes</param>
  /// <param name="to">0: all</param>
  public void Send(string topic, byte[] payload = null, ulong to = 0) {
    NativeError error;
    Result result;
    fixed (byte* text = Native.Text(topic))
    fixed (byte* bytes = payload) {
      result = Native.tandem_channel_send(handle, text, bytes,
                                          (UIntPtr)(payload == null ? 0 : payload.Length), to,
                                          &error);
    }
    below.Calls?.Rethrow();
    Native.Check(result, ref error);
  }

  /// <summary>Adds the messages of the last poll.</summary>
  /// <returns>their number</returns>
  public int ReadMessages(List<Message> into) {
    var count = Count();
    if (count > events.Length) {
      events = new NativeEvent[2 * count];
      count = Count();
    }
    Messages.Add(events, count, into);
    return count;
  }

  private int Count() {
    fixed (NativeEvent* at = events) {
      return (int)Native.tandem_channel_events(handle, at, (UIntPtr)events.Length);
    }
  }
}

internal static unsafe class Messages {
  internal static void Add(NativeEvent[] events, int count, List<Message> into) {
    if (into == null) throw new ArgumentNullException(nameof(into));
    for (var i = 0; i < count; ++i) {
      into.Add(new Message {From = events[i].From,
                            StampNs = events[i].StampNs,
                            Topic = Text(events[i].Topic, (int)events[i].TopicSize),
                            Payload = Bytes(events[i].Payload, (int)events[i].PayloadSize)});
    }
  }

  internal static string Text(byte* text, int size) =>
      size == 0 ? "" : System.Text.Encoding.UTF8.GetString(text, size);

  private static byte[] Bytes(byte* from, int size) {
    var bytes = new byte[size];
    if (size > 0) System.Runtime.InteropServices.Marshal.Copy((IntPtr)from, bytes, 0, size);
    return bytes;
  }
}

}  // namespace Tandem
