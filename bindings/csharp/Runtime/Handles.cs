// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Runtime.InteropServices;

namespace Tandem {

/// <summary>An object of the library. It holds the objects that must outlive it: they are freed
/// after it, whether by Dispose or by the collector.</summary>
internal abstract class NativeHandle : SafeHandle {
  private SafeHandle[] parents = new SafeHandle[0];

  protected NativeHandle() : base(IntPtr.Zero, true) {}

  public override bool IsInvalid => handle == IntPtr.Zero;

  /// <summary>Takes over an object of the library, or throws its error.</summary>
  internal void Adopt(IntPtr made, ref NativeError error, params SafeHandle[] outliving) {
    if (made == IntPtr.Zero) throw error.Thrown();
    foreach (var parent in outliving) {
      var added = false;
      parent.DangerousAddRef(ref added);
    }
    parents = outliving;
    SetHandle(made);
  }

  protected abstract void Free();

  protected override bool ReleaseHandle() {
    Free();
    foreach (var parent in parents) parent.DangerousRelease();
    return true;
  }
}

internal sealed class WorldHandle : NativeHandle {
  protected override void Free() => Native.tandem_world_destroy(handle);
}

internal sealed class QueryHandle : NativeHandle {
  internal GCHandle User;

  protected override void Free() {
    Native.tandem_query_destroy(handle);
    User.Free();
  }
}

internal sealed class NetworkHandle : NativeHandle {
  protected override void Free() => Native.tandem_network_destroy(handle);
}

internal sealed class TransportHandle : NativeHandle {
  /// <summary>Of a transport that calls the program; others belong to a network or a
  /// channel.</summary>
  internal GCHandle User;
  /// <summary>Kept while the library may call it; null for the others.</summary>
  internal TransportCalls Calls;

  protected override void Free() {
    if (!User.IsAllocated) return;
    Native.tandem_transport_destroy(handle);
    User.Free();
  }
}

internal sealed class ChannelHandle : NativeHandle {
  protected override void Free() => Native.tandem_channel_destroy(handle);
}

internal sealed class PeerHandle : NativeHandle {
  protected override void Free() => Native.tandem_peer_destroy(handle);
}

internal sealed class SessionHandle : NativeHandle {
  internal GCHandle User;
  internal SessionCalls Calls;

  protected override void Free() {
    Native.tandem_session_destroy(handle);
    User.Free();
  }
}

}  // namespace Tandem
