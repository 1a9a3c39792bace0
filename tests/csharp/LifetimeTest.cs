// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.IO;
using System.Runtime.CompilerServices;
using Tandem;

/// <summary>What is not disposed of is freed by the collector, what it needs after it, and nothing
/// that is in use.</summary>
internal static class LifetimeTest {
  internal static void Run() {
    AnyOrderWillDo();
    APeerLivesAsLongAsItsWorld();
    WhatIsLeftIsFreed();
  }

  private static void AnyOrderWillDo() {
    var network = new Network(default(Link), 1, Site.Start);
    var channel = new Channel(network.Transport(1));
    var world = new World();
    var query = new Query(world);
    var peer = new Peer(world, channel.Transport);
    peer.Share("cube", world.AddBody(BodyDef.Default));
    network.Dispose();
    channel.Dispose();
    world.Dispose();
    // All that they stand on is there.
    query.Update();
    peer.BeforeStep(Site.Start);
    peer.AfterStep(Site.Start + Site.StepNs);
    peer.Dispose();
    peer.Dispose();  // nothing happens
    query.Dispose();
    Check.Throws<ObjectDisposedException>(() => peer.BeforeStep(Site.Start), "a peer that is gone");
    Check.Throws<ObjectDisposedException>(() => world.Step(0.01), "a world, once its peer is gone");
    Check.Throws<ObjectDisposedException>(() => query.Update(), "a query that is gone");
    Check.Throws<ObjectDisposedException>(() => channel.Poll(Site.Start), "a channel, likewise");
    Check.Throws<ObjectDisposedException>(() => network.Advance(Site.Start), "a network, likewise");
  }

  private static void APeerLivesAsLongAsItsWorld() {
    var worlds = new World[20];
    var peers = new WeakReference[worlds.Length];
    for (var i = 0; i < peers.Length; ++i) {
      worlds[i] = new World();
      peers[i] = Forgotten(worlds[i]);
    }
    Collect();
    Check.That(Array.TrueForAll(peers, peer => peer.IsAlive),
               "no peer is freed by another thread while its world is used");
    foreach (var world in worlds) world.Step(0.01);
  }

  [MethodImpl(MethodImplOptions.NoInlining)]
  private static WeakReference Forgotten(World world) => new WeakReference(
      new Peer(world, new Network(default(Link), 1, Site.Start).Transport(1)));

  private sealed class Silence : ITransport {
    public ulong Self => 1;
    public int MaxPacket => 0;
    public bool Post(ulong to, byte[] packet, int size, Delivery delivery) => true;
    public void Drain(Inbox inbox) {}
    public void ListPeers(PeerList list) => list.Add(2, true);
    public void Drop(ulong peer, string reason) {}
  }

  [MethodImpl(MethodImplOptions.NoInlining)]
  private static WeakReference Abandoned(int kind) {
    var world = new World();
    var body = world.AddBody(BodyType.Dynamic, Shape.Sphere(1), Pose.Identity);
    for (var i = 0; i < 300; ++i) world.AddBody(BodyDef.Default);
    new Query(world).Update();
    new Rope(world, RopeDef.Default).Bodies(null);
    var transport = kind % 2 == 0 ? new Network(default(Link), 1, Site.Start).Transport(1)
                                  : new Transport(new Silence());
    if (kind % 4 == 3) {
      new Session(world, transport).Share("ball", body);
      return new WeakReference(world);
    }
    if (kind % 4 == 2) transport = new Channel(transport).Transport;
    var peer = new Peer(world, transport);
    peer.Share("ball", body);
    peer.BeforeStep(Site.Start);
    world.Step(1e-9 * Site.StepNs);
    peer.AfterStep(Site.Start + Site.StepNs);
    return new WeakReference(world);
  }

  private static void WhatIsLeftIsFreed() {
    // The first objects take one-time memory; after them the memory of each object while it lives
    // is counted.
    for (var i = 0; i < 8; ++i) Abandoned(i);
    var kept = Kept(100);
    Collect();
    var before = ResidentBytes();
    var worlds = new WeakReference[400];
    for (var i = 0; i < worlds.Length; ++i) {
      worlds[i] = Abandoned(i);
      if (i % 50 == 49) Collect();
    }
    Collect();
    var grown = ResidentBytes() - before;
    var alive = Array.FindAll(worlds, world => world.IsAlive).Length;
    // The stack is looked at with caution: some may seem to be in use.
    Check.That(alive < 20, $"{alive} of {worlds.Length} abandoned worlds are still there");
    Check.That(grown < 0.25 * kept * worlds.Length,
               $"{worlds.Length} abandoned worlds of {kept >> 10} KB have left {grown >> 10} KB");
  }

  /// <summary>Bytes of one of as many that are not abandoned.</summary>
  [MethodImpl(MethodImplOptions.NoInlining)]
  private static long Kept(int count) {
    var before = ResidentBytes();
    var held = new object[count];
    for (var i = 0; i < held.Length; ++i) held[i] = Abandoned(i).Target;
    var grown = ResidentBytes() - before;
    GC.KeepAlive(held);
    return grown / held.Length;
  }

  private static long ResidentBytes() =>
      4096 * long.Parse(File.ReadAllText("/proc/self/statm").Split(' ')[1]);

  private static void Collect() {
    for (var i = 0; i < 3; ++i) {
      GC.Collect();
      GC.WaitForPendingFinalizers();
    }
  }
}
