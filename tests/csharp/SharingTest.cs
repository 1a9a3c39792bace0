// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Collections.Generic;
using System.Text;
using Tandem;

/// <summary>A world with one body that is shared, and its peer.</summary>
internal sealed class Site : IDisposable {
  internal const long Start = 1000000000, StepNs = 16666667;

  internal readonly World World = WorldTest.Weightless();
  internal readonly BodyId Body;
  internal readonly Peer Peer;

  internal Site(Transport transport, double x) {
    var body = BodyDef.Default;
    body.Pose = new Pose(x, 0, 0);
    Body = World.AddBody(body);
    var def = PeerDef.Default;
    def.AuthorityRamp = 0.0;
    Peer = new Peer(World, transport, def);
    Peer.Share("cube", Body);
  }

  internal double X => World.State(Body).Pose.Position.X;

  internal void Step(long k) {
    Peer.BeforeStep(Start + k * StepNs);
    World.Step(1e-9 * StepNs);
    Peer.AfterStep(Start + (k + 1) * StepNs);
  }

  /// <summary>In no order that is asked for.</summary>
  public void Dispose() {
    World.Dispose();
    Peer.Dispose();
  }
}

internal static class SharingTest {
  private static readonly SharedId cube = SharedId.Of("cube");

  internal static void Run() {
    TwoMeetInTheMiddle();
    AnActCountsAtBoth();
    AHandMovesAndLeaves();
    AChannelCarriesMessages();
    AWireOfOnesOwnCarriesAll();
  }

  private static void Frames(Network network, Site[] sites, int from, int to,
                             Action<int> before = null) {
    for (var k = from; k < to; ++k) {
      network.Advance(Site.Start + k * Site.StepNs);
      before?.Invoke(k);
      foreach (var site in sites) site.Step(k);
    }
  }

  private static void Pair(double apart, Action<Network, Site[]> test) {
    using (var network = new Network(new Link {Latency = 0.03}, 1, Site.Start))
    using (var a = new Site(network.Transport(1), 0))
    using (var b = new Site(network.Transport(2), apart)) {
      test(network, new[] {a, b});
    }
  }

  private static void TwoMeetInTheMiddle() => Pair(0.1, (network, sites) => {
    Frames(network, sites, 0, 240);
    Check.Near(sites[0].X, sites[1].X, 1e-4, "one of two copies");
    Check.Near(sites[0].X, 0.05, 0.005, "their middle");
    var stats = sites[0].Peer.Stats;
    Check.That(stats.UpdatesReceived > 200 && stats.PacketsRejected == 0, "what came was read");
    Check.That(cube != SharedId.Of("Cube") && cube == SharedId.Of("cube"), "names are ids");
  });

  private static void AnActCountsAtBoth() => Pair(0, (network, sites) => {
    var act = ActDef.Default;
    act.Body = cube;
    Check.Refused(() => sites[0].Peer.Act(act), "");  // it does nothing
    act.Twist = new Twist(new Vec3(0.5, 0, 0), Vec3.Zero);
    Check.That(act.Pose == null && act.Twist.Value.Linear.X == 0.5, "what an act sets");
    Frames(network, sites, 0, 120, k => {
      if (k == 60) sites[0].Peer.Act(act);
    });
    foreach (var site in sites) Check.Near(site.X, 0.5, 0.02, "a second at 0.5 m/s");
  });

  private static void AHandMovesAndLeaves() => Pair(0, (network, sites) => {
    var def = GrabDef.Default;
    def.Body = cube;
    var grab = sites[0].Peer.Grab(def);
    Frames(network, sites, 0, 240, k => sites[0].Peer.Move(
        grab, new Vec3(Math.Min(k / 60.0, 1), 0, 0), Site.Start + k * Site.StepNs));
    foreach (var site in sites) Check.Near(site.X, 1, 0.01, "where a hand has gone");
    sites[0].Peer.Release(grab);
    Check.Refused(() => sites[0].Peer.Release(grab + 7), "grab");
    sites[0].Peer.Leave(Site.Start + 240 * Site.StepNs);
    sites[1].Peer.Unshare(cube);
    Check.Refused(() => sites[1].Peer.Unshare(cube), "");
  });

  private static void AChannelCarriesMessages() {
    using (var network = new Network(new Link {Latency = 0.05, Loss = 0.3}, 3, Site.Start))
    using (var first = new Channel(network.Transport(1)))
    using (var second = new Channel(network.Transport(2)))
    using (var a = new Site(first.Transport, 0))
    using (var b = new Site(second.Transport, 0.1)) {
      var messages = new List<Message>();
      Frames(network, new[] {a, b}, 0, 240, k => {
        var now = Site.Start + k * Site.StepNs;
        first.Poll(now);
        second.Poll(now);
        if (k == 10) {
          for (var i = 0; i < 20; ++i) first.Send("tür", Encoding.UTF8.GetBytes("auf" + i));
        }
        var before = messages.Count;
        Check.That(second.ReadMessages(messages) == messages.Count - before, "messages are counted");
      });
      Check.That(messages.Count == 20, $"each comes once: {messages.Count} of 20");
      for (var i = 0; i < messages.Count; ++i) {
        Check.That(messages[i].Topic == "tür" && messages[i].From == 1 &&
                       Encoding.UTF8.GetString(messages[i].Payload) == "auf" + i,
                   $"message {i} is what was sent");
        Check.That(messages[i].StampNs == Site.Start + 10 * Site.StepNs, "and says when");
      }
      Check.Near(a.X, b.X, 1e-3, "one of two copies beside messages");
      Check.Refused(() => first.Send(new string('t', 65)), "topic");
      Check.Refused(() => first.Send("a\0b"), "must hold no character 0");
      Check.Refused(() => first.Poll(0), "");
    }
  }

  /// <summary>What one posts waits here for the other.</summary>
  private sealed class Wire : ITransport {
    internal Wire Other;
    internal bool Dropped;
    internal string Reason = "";
    internal Exception Fault;
    private readonly Queue<byte[]> packets = new Queue<byte[]>();

    public ulong Self { get; set; }
    public int MaxPacket => 512;

    public bool Post(ulong to, byte[] packet, int size, Delivery delivery) {
      if (Fault != null) throw Fault;
      Check.That(size <= MaxPacket && to == Other.Self, "packets are no longer than was said");
      var copy = new byte[size];
      Array.Copy(packet, copy, size);
      Other.packets.Enqueue(copy);
      return true;
    }

    internal void Inject(byte[] packet) => packets.Enqueue(packet);

    public void Drain(Inbox inbox) {
      while (packets.Count > 0) {
        var packet = packets.Dequeue();
        inbox.Receive(Other.Self, packet, packet.Length);
      }
    }

    public void ListPeers(PeerList list) => list.Add(Other.Self, !Dropped);

    public void Drop(ulong peer, string reason) {
      Check.That(peer == Other.Self, "the sender is cut off");
      Dropped = true;
      Reason = reason;
    }
  }

  private static void AWireOfOnesOwnCarriesAll() {
    var one = new Wire {Self = 1};
    var two = new Wire {Self = 2, Other = one};
    one.Other = two;
    using (var first = new Transport(one))
    using (var second = new Transport(two))
    using (var a = new Site(first, 0))
    using (var b = new Site(second, 0.1)) {
      for (var k = 0; k < 240; ++k) {
        if (k % 50 == 0) GC.Collect();  // what is called from outside is still there
        a.Step(k);
        b.Step(k);
      }
      Check.Near(a.X, b.X, 1e-4, "one of two copies over a wire");
      one.Fault = new InvalidCastException("cut");
      try {
        a.Step(240);
        Check.That(false, "what a transport throws comes out");
      } catch (InvalidOperationException thrown) {
        Check.That(thrown.InnerException == one.Fault, "as it was");
      }
      one.Fault = null;
      var nonsense = new byte[40];
      for (var i = 0; i < nonsense.Length; ++i) nonsense[i] = 0xff;
      one.Inject(nonsense);
      a.Step(241);
      Check.That(one.Dropped && one.Reason.Length > 0, "who sends nonsense is cut off");
      Check.Refused(() => new Transport(new Wire()), "self");
    }
  }
}
