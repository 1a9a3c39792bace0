// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Runtime.InteropServices;

namespace Tandem {

[StructLayout(LayoutKind.Sequential)]
internal struct NativeSessionDef {
  public double Rate;
  public PeerDef Peer;
  public IntPtr Make, Remove;
  public uint MaxSpawned;
  public uint MaxSpawnedOfOne;
  public IntPtr Clock;
  public IntPtr User;
}

[StructLayout(LayoutKind.Sequential)]
internal unsafe struct NativeKey {
  public fixed byte Bytes[32];
}

[StructLayout(LayoutKind.Sequential)]
internal struct NativeTrusted {
  public ulong Peer;
  public NativeKey PublicKey;
}

[StructLayout(LayoutKind.Sequential)]
internal unsafe struct NativeCredentials {
  public NativeKey* SessionKey;
  public NativeKey* Identity;
  public NativeTrusted* Trusted;
  public UIntPtr TrustedCount;
  public NativeKey* Organiser;
  public byte* Certificate;
  public UIntPtr CertificateSize;
}

[StructLayout(LayoutKind.Sequential)]
internal unsafe struct NativeTcpDef {
  public ulong Self;
  public ulong SceneHash;
  public int ListenPort;
  public int Insecure;
  public byte* ListenAddress;
  public byte* Connect;
  public NativeCredentials Credentials;
}

[StructLayout(LayoutKind.Sequential)]
internal unsafe struct NativeUdpDef {
  public ulong Self;
  public ulong SceneHash;
  public int ListenPort;
  public ClockSource Clock;
  public byte* ListenAddress;
  public byte* Connect;
  public NativeCredentials Credentials;
  public double KbitPerS;
  public int Relay;
}

[StructLayout(LayoutKind.Sequential)]
internal unsafe struct NativeMember {
  public ulong Id;
  public int Connected;
  public fixed byte Reason[128];
  public double RoundTrip;
  public double KbitPerS;
  public ulong PacketsIn, PacketsOut, BytesIn, BytesOut;
}

[UnmanagedFunctionPointer(CallingConvention.Cdecl)]
internal unsafe delegate int MakeFunction(IntPtr user, byte* what, UIntPtr size, BodyId* body);
[UnmanagedFunctionPointer(CallingConvention.Cdecl)]
internal delegate void RemoveFunction(IntPtr user, BodyId body);
[UnmanagedFunctionPointer(CallingConvention.Cdecl)]
internal delegate long ClockFunction(IntPtr user);
[UnmanagedFunctionPointer(CallingConvention.Cdecl)]
internal delegate void BeforeStepFunction(IntPtr user, long nowNs);

/// <summary>Sessions.</summary>
internal static unsafe partial class Native {
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_key_make(NativeKey* key, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_key_public(NativeKey* identity, NativeKey* key,
                                                  NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern ulong tandem_key_peer(NativeKey* public_key);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_session_def_init(out NativeSessionDef def);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_tcp_def_init(out NativeTcpDef def);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_udp_def_init(out NativeUdpDef def);
  [DllImport(Library, CallingConvention = C)]
  internal static extern IntPtr tandem_session_create_tcp(WorldHandle world, NativeTcpDef* tcp,
                                                          NativeSessionDef* def,
                                                          NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern IntPtr tandem_session_create_udp(WorldHandle world, NativeUdpDef* udp,
                                                          NativeSessionDef* def,
                                                          NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern IntPtr tandem_session_create(WorldHandle world, TransportHandle transport,
                                                      NativeSessionDef* def, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_session_destroy(IntPtr session);

  [DllImport(Library, CallingConvention = C)]
  internal static extern ulong tandem_session_self(SessionHandle session);
  [DllImport(Library, CallingConvention = C)]
  internal static extern int tandem_session_port(SessionHandle session);
  [DllImport(Library, CallingConvention = C)]
  internal static extern long tandem_session_now(SessionHandle session);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_session_advance(SessionHandle session, long now_ns,
                                                       IntPtr before_step, IntPtr user,
                                                       Progress* progress, NativeError* error);

  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_session_share(SessionHandle session, byte[] name,
                                                     BodyId body, ulong owner, SharedId* id,
                                                     NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_session_share_all(SessionHandle session, byte[] name,
                                                         BodyId* bodies, UIntPtr count,
                                                         ulong owner, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_session_unshare(SessionHandle session, SharedId id,
                                                       NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_session_body(SessionHandle session, SharedId id,
                                                    BodyId* body, NativeError* error);

  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_session_grab(SessionHandle session, GrabDef* def,
                                                    uint* grab, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_session_move(SessionHandle session, uint grab, Vec3 anchor,
                                                    int* holds, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_session_release(SessionHandle session, uint grab,
                                                       NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_session_act(SessionHandle session, ActDef* def,
                                                   NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_session_spawn(SessionHandle session, byte[] what,
                                                     Pose* pose, Twist* twist, SharedId* id,
                                                     NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_session_despawn(SessionHandle session, SharedId id,
                                                       NativeError* error);

  [DllImport(Library, CallingConvention = C)]
  internal static extern UIntPtr tandem_session_joined(SessionHandle session, ulong* peers,
                                                       UIntPtr capacity);
  [DllImport(Library, CallingConvention = C)]
  internal static extern UIntPtr tandem_session_left(SessionHandle session, ulong* peers,
                                                     UIntPtr capacity);
  [DllImport(Library, CallingConvention = C)]
  internal static extern UIntPtr tandem_session_members(SessionHandle session,
                                                        NativeMember* members, UIntPtr capacity);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_session_send(SessionHandle session, byte* topic,
                                                    byte* payload, UIntPtr size, ulong to,
                                                    NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern UIntPtr tandem_session_events(SessionHandle session, NativeEvent* events,
                                                       UIntPtr capacity);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_session_get_stats(SessionHandle session,
                                                       SessionStats* stats);
}

}  // namespace Tandem
