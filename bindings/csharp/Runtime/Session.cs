// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;

namespace Tandem {

/// <summary>One participant of a session with all its parts: clock, steps of fixed length, peer,
/// transport, messages. It steps its world, which no other code may step meanwhile:
///
///     var session = new Session(world, new TcpOptions {Self = 1, ListenPort = 7777});
///     session.Share("cube", cube);
///     each frame:  session.Advance(session.Now);
///
/// Callbacks must not advance or dispose of it; their exceptions leave the call, once it has
/// completed.</summary>
public sealed unsafe class Session : IDisposable {
  private readonly SessionHandle handle = new SessionHandle();
  private readonly World world;
  private readonly Transport transport;  // null: its own
  private readonly SessionCalls calls;
  private NativeEvent[] events = new NativeEvent[8];
  private NativeMember[] members = new NativeMember[4];

  private delegate IntPtr Creation(NativeSessionDef* def, NativeError* error);

  public Session(World world, TcpOptions tcp, SessionOptions options = null)
      : this(world, options, null) {
    if (tcp == null) throw new ArgumentNullException(nameof(tcp));
    using (var memory = new NativeMemory()) {
      var native = tcp.At(memory);
      var at = &native;
      Create(options, (def, error) =>
                          Native.tandem_session_create_tcp(world.Handle, at, def, error));
    }
  }

  public Session(World world, UdpOptions udp, SessionOptions options = null)
      : this(world, options, null) {
    if (udp == null) throw new ArgumentNullException(nameof(udp));
    using (var memory = new NativeMemory()) {
      var native = udp.At(memory);
      var at = &native;
      Create(options, (def, error) =>
                          Native.tandem_session_create_udp(world.Handle, at, def, error));
    }
  }

  /// <summary>With a transport of a network or the program's, but not a channel's: a session has
  /// its own messages.</summary>
  public Session(World world, Transport transport, SessionOptions options = null)
      : this(world, options, transport) {
    if (transport == null) throw new ArgumentNullException(nameof(transport));
    Create(options, (def, error) => Native.tandem_session_create(world.Handle, transport.Handle,
                                                                 def, error));
    transport.Dependents.Add(this);
  }

  private Session(World world, SessionOptions options, Transport transport) {
    this.world = world ?? throw new ArgumentNullException(nameof(world));
    this.transport = transport;
    calls = new SessionCalls(options ?? new SessionOptions());
  }

  private void Create(SessionOptions options, Creation create) {
    // Weak: the handle keeps the calls alive, and is freed when it is unreachable.
    var user = GCHandle.Alloc(calls, GCHandleType.Weak);
    var def = calls.Def(options ?? new SessionOptions(), GCHandle.ToIntPtr(user));
    NativeError error;
    var made = create(&def, &error);
    if (made == IntPtr.Zero) user.Free();
    if (transport == null) {
      handle.Adopt(made, ref error, world.Handle);
    } else {
      handle.Adopt(made, ref error, world.Handle, transport.Handle);
    }
    handle.User = user;
    handle.Calls = calls;
    world.Dependents.Add(this);
  }

  /// <summary>Announces that it leaves.</summary>
  public void Dispose() {
    handle.Dispose();
    world.Dependents.Remove(this);
    transport?.Dependents.Remove(this);
  }

  public ulong Self => Native.tandem_session_self(handle);

  /// <summary>Port of its own socket; 0 if it has none.</summary>
  public int Port => Native.tandem_session_port(handle);

  /// <summary>Session time, ns.</summary>
  public long Now {
    get {
      var now = Native.tandem_session_now(handle);
      Rethrow();
      return now;
    }
  }

  /// <summary>Make the steps that are due at `nowNs`, and only those; never blocks. The first call
  /// begins. The world's contacts are those of the last step.</summary>
  /// <param name="beforeStep">called with the session time at which a step begins: to move hands,
  /// apply impulses, read messages. Keep the delegate: a new one in each frame is garbage.</param>
  public Progress Advance(long nowNs, Action<long> beforeStep = null) {
    var outer = calls.OnStep;  // of an outer Advance, from which this call is refused
    calls.OnStep = beforeStep;
    Progress progress;
    NativeError error;
    Result result;
    try {
      result = Native.tandem_session_advance(
          handle, nowNs, beforeStep == null ? IntPtr.Zero : SessionCalls.BeforeStepPointer,
          GCHandle.ToIntPtr(handle.User), &progress, &error);
    } finally {
      calls.OnStep = outer;
    }
    Check(result, ref error);
    return progress;
  }

  /// <summary>Share a body with all members that share one under the same name.</summary>
  /// <param name="owner">the peer that alone moves it; 0 = none</param>
  public SharedId Share(string name, BodyId body, ulong owner = 0) {
    SharedId id;
    NativeError error;
    Check(Native.tandem_session_share(handle, Native.Text(name), body, owner, &id, &error),
          ref error);
    return id;
  }

  /// <summary>Share all bodies of one object, as "name/0", "name/1" and so on, or none of
  /// them.</summary>
  public void Share(string name, BodyId[] bodies, ulong owner = 0) {
    NativeError error;
    fixed (BodyId* all = bodies) {
      Check(Native.tandem_session_share_all(handle, Native.Text(name), all,
                                            (UIntPtr)(bodies == null ? 0 : bodies.Length), owner,
                                            &error),
            ref error);
    }
  }

  public void Unshare(SharedId id) {
    NativeError error;
    Check(Native.tandem_session_unshare(handle, id, &error), ref error);
  }

  /// <summary>The local instance of a shared body.</summary>
  public BodyId Body(SharedId id) {
    BodyId body;
    NativeError error;
    Check(Native.tandem_session_body(handle, id, &body, &error), ref error);
    return body;
  }

  /// <summary>Hold a shared body with a spring that all members simulate.</summary>
  public uint Grab(GrabDef def) {
    uint grab;
    NativeError error;
    Check(Native.tandem_session_grab(handle, &def, &grab, &error), ref error);
    return grab;
  }

  /// <param name="anchor">position of the hand when the next step begins, m, world</param>
  /// <returns>whether it still holds: not once it is released or its body is removed</returns>
  public bool Move(uint grab, Vec3 anchor) {
    int holds;
    NativeError error;
    Check(Native.tandem_session_move(handle, grab, anchor, &holds, &error), ref error);
    return holds != 0;
  }

  /// <summary>Release it, if it still holds.</summary>
  public void Release(uint grab) {
    NativeError error;
    Check(Native.tandem_session_release(handle, grab, &error), ref error);
  }

  /// <summary>As Peer.Act.</summary>
  public void Act(ActDef def) {
    NativeError error;
    Check(Native.tandem_session_act(handle, &def, &error), ref error);
  }

  /// <summary>Make a body at every member, later ones included, and share it.</summary>
  /// <param name="what">argument of SessionOptions.Make at every member, at most 512 bytes of
  /// UTF-8</param>
  /// <param name="twist">null: at rest</param>
  public SharedId Spawn(string what, Pose pose, Twist? twist = null) {
    var moving = twist.GetValueOrDefault();
    SharedId id;
    NativeError error;
    Check(Native.tandem_session_spawn(handle, Native.Text(what), &pose,
                                      twist.HasValue ? &moving : null, &id, &error),
          ref error);
    return id;
  }

  /// <summary>Remove a body that any member has spawned, at every member.</summary>
  public void Despawn(SharedId id) {
    NativeError error;
    Check(Native.tandem_session_despawn(handle, id, &error), ref error);
  }

  /// <summary>Peers that connected during the last Advance. Fills the array as far as it goes; it
  /// may be null.</summary>
  /// <returns>the total number</returns>
  public int Joined(ulong[] into) {
    fixed (ulong* peers = into) {
      return (int)Native.tandem_session_joined(handle, peers,
                                               (UIntPtr)(into == null ? 0 : into.Length));
    }
  }

  /// <summary>The same for peers that disconnected.</summary>
  public int Left(ulong[] into) {
    fixed (ulong* peers = into) {
      return (int)Native.tandem_session_left(handle, peers,
                                             (UIntPtr)(into == null ? 0 : into.Length));
    }
  }

  /// <summary>Adds all peers ever seen, by ascending id.</summary>
  /// <returns>their number</returns>
  public int ReadMembers(List<Member> into) {
    if (into == null) throw new ArgumentNullException(nameof(into));
    var count = CountMembers();
    if (count > members.Length) {
      members = new NativeMember[2 * count];
      count = CountMembers();
    }
    Rethrow();
    fixed (NativeMember* all = members) {
      for (var i = 0; i < count; ++i) into.Add(Of(all + i));
    }
    return count;
  }

  /// <summary>It leaves before the next step.</summary>
  /// <param name="topic">at most 64 bytes; those that begin with "tandem." are reserved</param>
  /// <param name="to">0: all</param>
  public void Send(string topic, byte[] payload = null, ulong to = 0) {
    NativeError error;
    fixed (byte* text = Native.Text(topic))
    fixed (byte* bytes = payload) {
      Check(Native.tandem_session_send(handle, text, bytes,
                                       (UIntPtr)(payload == null ? 0 : payload.Length), to,
                                       &error),
            ref error);
    }
  }

  /// <summary>Adds the messages received during the last Advance, within `beforeStep` those up to
  /// that step.</summary>
  /// <returns>their number</returns>
  public int ReadMessages(List<Message> into) {
    var count = CountEvents();
    if (count > events.Length) {
      events = new NativeEvent[2 * count];
      count = CountEvents();
    }
    Messages.Add(events, count, into);
    return count;
  }

  public SessionStats Stats {
    get {
      SessionStats stats;
      Native.tandem_session_get_stats(handle, &stats);
      return stats;
    }
  }

  private int CountEvents() {
    fixed (NativeEvent* at = events) {
      return (int)Native.tandem_session_events(handle, at, (UIntPtr)events.Length);
    }
  }

  private int CountMembers() {
    fixed (NativeMember* at = members) {
      return (int)Native.tandem_session_members(handle, at, (UIntPtr)members.Length);
    }
  }

  private static Member Of(NativeMember* from) {
    var length = 0;
    while (length < 128 && from->Reason[length] != 0) ++length;
    return new Member {Id = from->Id,
                       Connected = from->Connected != 0,
                       Reason = Messages.Text(from->Reason, length),
                       RoundTrip = from->RoundTrip,
                       KbitPerS = from->KbitPerS,
                       PacketsIn = from->PacketsIn,
                       PacketsOut = from->PacketsOut,
                       BytesIn = from->BytesIn,
                       BytesOut = from->BytesOut};
  }

  private void Rethrow() {
    transport?.Calls?.Rethrow();
    calls.Rethrow();
  }

  private void Check(Result result, ref NativeError error) {
    Rethrow();
    Native.Check(result, ref error);
  }
}

}  // namespace Tandem
