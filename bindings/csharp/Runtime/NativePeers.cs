// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Runtime.InteropServices;

namespace Tandem {

[StructLayout(LayoutKind.Sequential)]
internal struct NativeTransportDef {
  public IntPtr User;
  public ulong Self;
  public IntPtr Post, Drain, Peers, Drop;
  public UIntPtr MaxPacket;
}

[StructLayout(LayoutKind.Sequential)]
internal unsafe struct NativeEvent {
  public ulong From;
  public long StampNs;
  public byte* Topic;
  public UIntPtr TopicSize;
  public byte* Payload;
  public UIntPtr PayloadSize;
}

[UnmanagedFunctionPointer(CallingConvention.Cdecl)]
internal unsafe delegate void ReceiveFunction(IntPtr inbox, ulong from, byte* bytes, UIntPtr size);
[UnmanagedFunctionPointer(CallingConvention.Cdecl)]
internal delegate void ListPeerFunction(IntPtr list, ulong peer, int connected);
[UnmanagedFunctionPointer(CallingConvention.Cdecl)]
internal unsafe delegate int PostFunction(IntPtr user, ulong to, byte* bytes, UIntPtr size,
                                          Delivery delivery);
[UnmanagedFunctionPointer(CallingConvention.Cdecl)]
internal delegate void DrainFunction(IntPtr user, IntPtr receive, IntPtr inbox);
[UnmanagedFunctionPointer(CallingConvention.Cdecl)]
internal delegate void PeersFunction(IntPtr user, IntPtr list, IntPtr into);
[UnmanagedFunctionPointer(CallingConvention.Cdecl)]
internal unsafe delegate void DropFunction(IntPtr user, ulong peer, byte* reason);

/// <summary>Transports, messages, sharing.</summary>
internal static unsafe partial class Native {
  [DllImport(Library, CallingConvention = C)]
  internal static extern IntPtr tandem_transport_create(NativeTransportDef* def,
                                                        NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_transport_destroy(IntPtr transport);
  [DllImport(Library, CallingConvention = C)]
  internal static extern IntPtr tandem_network_create(Link* link, ulong seed, long start_ns,
                                                      NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_network_destroy(IntPtr network);
  [DllImport(Library, CallingConvention = C)]
  internal static extern IntPtr tandem_network_transport(NetworkHandle network, ulong peer,
                                                         NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_network_advance(NetworkHandle network, long time_ns,
                                                       NativeError* error);

  [DllImport(Library, CallingConvention = C)]
  internal static extern IntPtr tandem_channel_create(TransportHandle transport,
                                                      NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_channel_destroy(IntPtr channel);
  [DllImport(Library, CallingConvention = C)]
  internal static extern IntPtr tandem_channel_transport(ChannelHandle channel);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_channel_poll(ChannelHandle channel, long now_ns,
                                                    NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_channel_send(ChannelHandle channel, byte* topic,
                                                    byte* payload, UIntPtr size, ulong to,
                                                    NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern UIntPtr tandem_channel_events(ChannelHandle channel, NativeEvent* events,
                                                       UIntPtr capacity);

  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_peer_def_init(out PeerDef def);
  [DllImport(Library, CallingConvention = C)]
  internal static extern IntPtr tandem_peer_create(WorldHandle world, TransportHandle transport,
                                                   PeerDef* def, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_peer_destroy(IntPtr peer);
  [DllImport(Library, CallingConvention = C)]
  internal static extern SharedId tandem_shared_id_of(byte[] name);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_peer_share(PeerHandle peer, SharedId id, BodyId body,
                                                  ulong owner, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_peer_unshare(PeerHandle peer, SharedId id,
                                                    NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_peer_before_step(PeerHandle peer, long now_ns,
                                                        NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_peer_after_step(PeerHandle peer, long now_ns,
                                                       NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_peer_leave(PeerHandle peer, long now_ns,
                                                  NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_grab_def_init(out GrabDef def);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_peer_grab(PeerHandle peer, GrabDef* def, uint* grab,
                                                 NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_peer_move(PeerHandle peer, uint grab, Vec3 anchor,
                                                 long now_ns, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_peer_release(PeerHandle peer, uint grab,
                                                    NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_act_def_init(out ActDef def);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_peer_act(PeerHandle peer, ActDef* def, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_peer_get_stats(PeerHandle peer, PeerStats* stats);
}

}  // namespace Tandem
