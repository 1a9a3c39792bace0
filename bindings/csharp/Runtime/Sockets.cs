// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using System.Text;

namespace Tandem {

/// <summary>A session key, or an X25519 key of a peer: 32 bytes.</summary>
public sealed unsafe class Key {
  private NativeKey native;

  public Key(byte[] bytes) {
    if (bytes == null || bytes.Length != 32) {
      throw new TandemException(Result.InvalidArgument,
                                $"key must be 32 bytes, not {(bytes == null ? 0 : bytes.Length)}");
    }
    fixed (byte* into = native.Bytes) Marshal.Copy(bytes, 0, (IntPtr)into, 32);
  }

  private Key() {}

  /// <summary>A new key from the system's generator.</summary>
  public static Key Make() {
    var key = new Key();
    NativeError error;
    fixed (NativeKey* into = &key.native) {
      Native.Check(Native.tandem_key_make(into, &error), ref error);
    }
    return key;
  }

  /// <summary>The public key to give to others.</summary>
  public Key Public {
    get {
      var key = new Key();
      NativeError error;
      fixed (NativeKey* from = &native)
      fixed (NativeKey* into = &key.native) {
        Native.Check(Native.tandem_key_public(from, into, &error), ref error);
      }
      return key;
    }
  }

  /// <summary>The peer id of a public key: only the owner of its secret can use it.</summary>
  public ulong Peer {
    get {
      fixed (NativeKey* key = &native) return Native.tandem_key_peer(key);
    }
  }

  public byte[] ToBytes() {
    var bytes = new byte[32];
    fixed (byte* from = native.Bytes) Marshal.Copy((IntPtr)from, bytes, 0, 32);
    return bytes;
  }

  internal NativeKey Value => native;
}

/// <summary>Who may take part in a protected session.</summary>
public sealed class Credentials {
  /// <summary>The same for all members, not zero.</summary>
  public Key SessionKey;
  /// <summary>Secret of this peer; null = a new one.</summary>
  public Key Identity;
  /// <summary>Public keys of accepted peers. With neither these nor an organiser: any
  /// member.</summary>
  public readonly Dictionary<ulong, Key> Trusted = new Dictionary<ulong, Key>();
  /// <summary>Public key of the organiser, whose certificates admit peers; null = none.</summary>
  public Key Organiser;
  /// <summary>Of this peer, if there is an organiser.</summary>
  public byte[] Certificate;
}

/// <summary>Options of one process in a session over TCP.</summary>
public sealed class TcpOptions {
  public ulong Self;            // unique in the session, never 0
  public ulong SceneHash;       // peers with a different one are refused; 0
  public int ListenPort;        // 0: a free one, see Session.Port; -1: dials only; -1
  public bool Insecure;         // allows other addresses than loopback without a key; false
  public string ListenAddress;  // numeric; null: "0.0.0.0"; "::" is IPv6 and IPv4
  public string[] Connect;      // "HOST:PORT" of peers; one is enough; null: none
  public readonly Credentials Credentials = new Credentials();  // no session key: loopback only

  public TcpOptions() {
    Native.tandem_tcp_def_init(out var def);
    ListenPort = def.ListenPort;
  }

  internal unsafe NativeTcpDef At(NativeMemory memory) {
    Native.tandem_tcp_def_init(out var def);
    def.Self = Self;
    def.SceneHash = SceneHash;
    def.ListenPort = ListenPort;
    def.Insecure = Insecure ? 1 : 0;
    def.ListenAddress = memory.Text(ListenAddress);
    def.Connect = memory.Text(Connect == null ? null : string.Join(" ", Connect));
    def.Credentials = memory.Of(Credentials);
    return def;
  }
}

/// <summary>Source of session time.</summary>
public enum ClockSource {
  Session = 0,  // agreed on in the session
  System = 1,   // hosts are disciplined by PTP or NTP
  None = 2      // each peer has its own; states are dated on arrival
}

/// <summary>Options of one process in a session over UDP, which is always encrypted.</summary>
public sealed class UdpOptions {
  public ulong Self;            // unique in the session, never 0
  public ulong SceneHash;       // peers with a different one are refused; 0
  public int ListenPort;        // 0: a free one, see Session.Port; 0
  public ClockSource Clock;     // Session
  public string ListenAddress;  // numeric; null: "0.0.0.0"; "::" is IPv6 and IPv4
  public string[] Connect;      // "HOST:PORT" of peers; one is enough; null: none
  public readonly Credentials Credentials = new Credentials();  // with a session key
  public double KbitPerS;       // budget of each link, headers counted; 256
  public bool Relay;  // forward for peers without a route, and be forwarded for; true

  public UdpOptions() {
    Native.tandem_udp_def_init(out var def);
    ListenPort = def.ListenPort;
    Clock = def.Clock;
    KbitPerS = def.KbitPerS;
    Relay = def.Relay != 0;
  }

  internal unsafe NativeUdpDef At(NativeMemory memory) {
    Native.tandem_udp_def_init(out var def);
    def.Self = Self;
    def.SceneHash = SceneHash;
    def.ListenPort = ListenPort;
    def.Clock = Clock;
    def.ListenAddress = memory.Text(ListenAddress);
    def.Connect = memory.Text(Connect == null ? null : string.Join(" ", Connect));
    def.Credentials = memory.Of(Credentials);
    def.KbitPerS = KbitPerS;
    def.Relay = Relay ? 1 : 0;
    return def;
  }
}

/// <summary>Memory that the library reads during one call.</summary>
internal sealed unsafe class NativeMemory : IDisposable {
  private readonly List<IntPtr> blocks = new List<IntPtr>();

  public void Dispose() {
    foreach (var block in blocks) Marshal.FreeHGlobal(block);
    blocks.Clear();
  }

  internal byte* Text(string text) => text == null ? null : Bytes(Native.Text(text));

  internal NativeCredentials Of(Credentials from) {
    var trusted = (NativeTrusted*)Block(from.Trusted.Count * sizeof(NativeTrusted));
    var count = 0;
    foreach (var pair in from.Trusted) {
      if (pair.Value == null) {
        throw new ArgumentException("Trusted[" + pair.Key + "] must be a key, is null");
      }
      trusted[count++] = new NativeTrusted {Peer = pair.Key, PublicKey = pair.Value.Value};
    }
    var certificate = from.Certificate;
    return new NativeCredentials {
        SessionKey = At(from.SessionKey),
        Identity = At(from.Identity),
        Trusted = trusted,
        TrustedCount = (UIntPtr)count,
        Organiser = At(from.Organiser),
        Certificate = certificate == null ? null : Bytes(certificate),
        CertificateSize = (UIntPtr)(certificate == null ? 0 : certificate.Length)};
  }

  private NativeKey* At(Key key) {
    if (key == null) return null;
    var at = (NativeKey*)Block(sizeof(NativeKey));
    *at = key.Value;
    return at;
  }

  private byte* Bytes(byte[] bytes) {
    var at = Block(bytes.Length);
    Marshal.Copy(bytes, 0, (IntPtr)at, bytes.Length);
    return at;
  }

  private byte* Block(int size) {
    if (size == 0) return null;
    var block = Marshal.AllocHGlobal(size);
    blocks.Add(block);
    return (byte*)block;
  }
}

}  // namespace Tandem
