// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;

namespace Tandem {

/// <summary>One participant of a session: shares bodies of a world with those of the other peers.
/// Each step is BeforeStep(now), World.Step(dt), AfterStep(now + dt), with session times in ns,
/// above 0. A Session does all that itself.</summary>
public sealed unsafe class Peer : IDisposable {
  private readonly PeerHandle handle = new PeerHandle();
  private readonly World world;
  private readonly Transport transport;

  public Peer(World world, Transport transport) : this(world, transport, PeerDef.Default) {}

  public Peer(World world, Transport transport, PeerDef def) {
    this.world = world ?? throw new ArgumentNullException(nameof(world));
    this.transport = transport ?? throw new ArgumentNullException(nameof(transport));
    NativeError error;
    handle.Adopt(Native.tandem_peer_create(world.Handle, transport.Handle, &def, &error),
                 ref error, world.Handle, transport.Handle);
    world.Dependents.Add(this);
    transport.Dependents.Add(this);
  }

  public void Dispose() {
    handle.Dispose();
    world.Dependents.Remove(this);
    transport.Dependents.Remove(this);
  }

  /// <param name="owner">the peer that alone moves it; 0 = none</param>
  public SharedId Share(string name, BodyId body, ulong owner = 0) {
    var id = SharedId.Of(name);
    Share(id, body, owner);
    return id;
  }

  public void Share(SharedId id, BodyId body, ulong owner = 0) {
    NativeError error;
    Check(Native.tandem_peer_share(handle, id, body, owner, &error), ref error);
  }

  public void Unshare(SharedId id) {
    NativeError error;
    Check(Native.tandem_peer_unshare(handle, id, &error), ref error);
  }

  public void BeforeStep(long nowNs) {
    NativeError error;
    Check(Native.tandem_peer_before_step(handle, nowNs, &error), ref error);
  }

  public void AfterStep(long nowNs) {
    NativeError error;
    Check(Native.tandem_peer_after_step(handle, nowNs, &error), ref error);
  }

  /// <summary>Tells the other peers to release this one's springs.</summary>
  public void Leave(long nowNs) {
    NativeError error;
    Check(Native.tandem_peer_leave(handle, nowNs, &error), ref error);
  }

  /// <summary>Hold a shared body with a spring that all peers simulate.</summary>
  public uint Grab(GrabDef def) {
    uint grab;
    NativeError error;
    Check(Native.tandem_peer_grab(handle, &def, &grab, &error), ref error);
    return grab;
  }

  /// <param name="nowNs">the start of the step to come</param>
  public void Move(uint grab, Vec3 anchor, long nowNs) {
    NativeError error;
    Check(Native.tandem_peer_move(handle, grab, anchor, nowNs, &error), ref error);
  }

  public void Release(uint grab) {
    NativeError error;
    Check(Native.tandem_peer_release(handle, grab, &error), ref error);
  }

  /// <summary>Act on a shared body, here and, as of the same session time, at all peers. Call it
  /// between steps.</summary>
  public void Act(ActDef def) {
    NativeError error;
    Check(Native.tandem_peer_act(handle, &def, &error), ref error);
  }

  public PeerStats Stats {
    get {
      PeerStats stats;
      Native.tandem_peer_get_stats(handle, &stats);
      return stats;
    }
  }

  private void Check(Result result, ref NativeError error) {
    transport.Calls?.Rethrow();
    Native.Check(result, ref error);
  }
}

}  // namespace Tandem
