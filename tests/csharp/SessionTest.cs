// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Collections.Generic;
using System.Linq;
using System.Text;
using System.Threading;
using Tandem;

internal static class SessionTest {
  private const long start = 1000000000, stepNs = 16666667;

  internal static void Run() {
    MembersAgreeAndSpawn();
    OverTcp();
    OverUdp();
    WhatIsWrongIsRefused();
  }

  /// <summary>A member in virtual time.</summary>
  private sealed class Room : IDisposable {
    internal readonly World World = WorldTest.Weightless();
    internal readonly BodyId Body;
    internal readonly List<BodyId> Spawned = new List<BodyId>();
    internal readonly List<Message> Messages = new List<Message>();
    internal readonly List<ulong> Came = new List<ulong>();
    internal Session Session;
    internal int Steps;
    internal Exception Fault;

    internal Room(double x = 0) {
      var body = BodyDef.Default;
      body.Pose = new Pose(x, 0, 0);
      Body = World.AddBody(body);
    }

    internal SessionOptions Options() {
      var options = new SessionOptions {Make = Make, Remove = Remove};
      options.Peer.AuthorityRamp = 0;
      return options;
    }

    internal double X => World.State(Body).Pose.Position.X;

    private BodyId? Make(string what) {
      if (what != "ball") return null;
      Spawned.Add(World.AddBody(BodyDef.Default));
      return Spawned.Last();
    }

    private void Remove(BodyId body) {
      World.RemoveBody(body);
      Check.That(Spawned.Remove(body), "what goes was spawned");
    }

    internal void Advance() {
      var progress = Session.Advance(Session.Now, BeforeStep);
      Check.That(progress.Status == StepStatus.Ok && !progress.SteppedElsewhere, "steps are made");
      Steps += progress.Steps;
      var joined = new ulong[2];
      Came.AddRange(joined.Take(Session.Joined(joined)));
    }

    private void BeforeStep(long now) {
      Check.That(now > 0, "steps have times");
      if (Fault != null) throw Fault;
      Session.ReadMessages(Messages);
    }

    public void Dispose() {
      World.Dispose();
      Session?.Dispose();
    }
  }

  private static void MembersAgreeAndSpawn() {
    using (var network = new Network(new Link {Latency = 0.03}, 1, start))
    using (var a = new Room(0))
    using (var b = new Room(0.1)) {
      var rooms = new[] {a, b};
      var step = 0;
      var id = default(SharedId);
      foreach (var room in rooms) {
        room.Session = new Session(room.World, network.Transport(room == a ? 1u : 2u),
                                   room.Options());
        id = room.Session.Share("cube", room.Body);
      }
      Action<int> run = steps => {
        for (var k = 0; k < steps; ++k) {
          network.Advance(start + ++step * stepNs);
          foreach (var room in rooms) room.Advance();
        }
      };
      run(240);
      Check.That(id == SharedId.Of("cube") && a.Session.Body(id) == a.Body, "a name is an id");
      Check.That(Math.Abs(a.Steps - 240) <= 1, $"240 steps are due in as many: {a.Steps}");
      Check.Near(a.X, b.X, 1e-4, "one of two copies in a session");
      Check.Near(a.X, 0.05, 0.005, "their middle");

      var def = GrabDef.Default;
      def.Body = id;
      var grab = a.Session.Grab(def);
      Check.That(a.Session.Move(grab, new Vec3(1, 0, 0)), "a hand holds");
      a.Session.Send("door", Encoding.UTF8.GetBytes("open"));
      var ball = b.Session.Spawn("ball", new Pose(0, 5, 0));
      run(240);
      Check.Near(b.X, 1, 0.01, "where a hand has gone, at the other");
      a.Session.Release(grab);
      Check.That(!a.Session.Move(grab, Vec3.Zero), "a hand that let go holds no longer");
      Check.That(b.Messages.Count == 1 && b.Messages[0].Topic == "door" &&
                     Encoding.UTF8.GetString(b.Messages[0].Payload) == "open",
                 "a message comes once");
      Check.That(a.Spawned.Count == 1 && b.Spawned.Count == 1, "what one spawns is at both");
      Check.Near(a.World.State(a.Spawned[0]).Pose.Position.Y, 5, 1e-6, "where it was spawned");
      var act = ActDef.Default;
      act.Body = ball;
      act.Pose = new Pose(0, 7, 0);
      a.Session.Act(act);
      run(60);
      Check.Near(b.World.State(b.Spawned[0]).Pose.Position.Y, 7, 1e-3, "where an act has put it");
      a.Session.Despawn(ball);
      run(60);
      Check.That(a.Spawned.Count == 0 && b.Spawned.Count == 0, "and goes at both");
      Check.That(a.Session.Stats.Peer.UpdatesReceived > 200, "what came is counted");

      a.Fault = new InvalidCastException("no");
      Check.Throws<InvalidOperationException>(() => run(2), "a step's program that throws");
      a.Fault = null;
      run(2);  // and it goes on
    }
  }

  /// <summary>A hand of the first takes the cube of both along; who goes says so.</summary>
  private static void PullAndLeave(Room a, Room b) {
    foreach (var room in new[] {a, b}) room.Session.Share("cube", room.Body);
    Until(20, () => a.Came.Count > 0 && b.Came.Count > 0, a, b);
    Check.That(a.Came.SequenceEqual(new[] {2ul}) && b.Came.SequenceEqual(new[] {1ul}),
               "both have seen the other come");
    var def = GrabDef.Default;
    def.Body = SharedId.Of("cube");
    def.Anchor = new Vec3(1, 0, 0);
    a.Session.Grab(def);
    Until(20, () => Math.Abs(a.X - 1) < 0.01 && Math.Abs(b.X - 1) < 0.01, a, b);
    Check.Near(b.X, 1, 0.01, "where a hand has gone, over a socket");
    var members = new List<Member>();
    Check.That(b.Session.ReadMembers(members) == 1 && members[0].Id == 1 && members[0].Connected &&
                   members[0].BytesIn > 1000,
               "the other is there");
    a.Session.Dispose();
    var left = new ulong[1];
    Until(3, () => b.Session.Left(left) == 1, b);
    Check.That(left[0] == 1, "who goes is seen to");
    members.Clear();
    b.Session.ReadMembers(members);
    Check.That(members.Count == 1 && !members[0].Connected && members[0].Reason.Length > 0,
               "and why");
  }

  private static void Until(double seconds, Func<bool> done, params Room[] rooms) {
    var end = DateTime.UtcNow.AddSeconds(seconds);
    while (!done() && DateTime.UtcNow < end) {
      foreach (var room in rooms) room.Advance();
      if (!done()) Thread.Sleep(1);
    }
  }

  private static void OverTcp() {
    using (var a = new Room())
    using (var b = new Room()) {
      a.Session = new Session(
          a.World, new TcpOptions {Self = 1, ListenPort = 0, ListenAddress = "127.0.0.1"},
          a.Options());
      Check.That(a.Session.Port > 0 && a.Session.Self == 1, "a free port is taken");
      b.Session = new Session(
          b.World, new TcpOptions {Self = 2, Connect = new[] {"127.0.0.1:" + a.Session.Port}},
          b.Options());
      PullAndLeave(a, b);
    }
  }

  private static void OverUdp() {
    Key key;
    try {
      key = Key.Make();
    } catch (TandemException thrown) {
      Check.That(thrown.Message.Contains("libsodium"), "a build without UDP says so");
      return;
    }
    Key one = Key.Make(), two = Key.Make();
    Check.That(!one.ToBytes().SequenceEqual(two.ToBytes()), "keys are not alike");
    Check.That(new Key(one.ToBytes()).Public.ToBytes().SequenceEqual(one.Public.ToBytes()) &&
                   !one.Public.ToBytes().SequenceEqual(one.ToBytes()),
               "a key has one public key");
    Check.That(one.Public.Peer != 0 && one.Public.Peer != two.Public.Peer &&
                   one.Public.Peer == new Key(one.Public.ToBytes()).Peer,
               "a public key is a peer's id");
    using (var a = new Room())
    using (var b = new Room()) {
      var options = Udp(1, key, one, 2, two.Public);
      a.Session = new Session(a.World, options, a.Options());
      options = Udp(2, key, two, 1, one.Public);
      options.Connect = new[] {"127.0.0.1:" + a.Session.Port};
      b.Session = new Session(b.World, options, b.Options());
      PullAndLeave(a, b);
    }
  }

  private static UdpOptions Udp(ulong self, Key key, Key identity, ulong other, Key trusted) {
    var options = new UdpOptions {Self = self, ListenAddress = "127.0.0.1"};
    options.Credentials.SessionKey = key;
    options.Credentials.Identity = identity;
    options.Credentials.Trusted[other] = trusted;
    return options;
  }

  private static void WhatIsWrongIsRefused() {
    using (var world = new World()) {
      Check.Refused(() => new Session(world, new TcpOptions {Self = 0}), "self");
      var options = new TcpOptions {Self = 1, Connect = new[] {"nowhere"}};
      Check.Refused(() => new Session(world, options), "nowhere");
      Check.Refused(() => new Key(new byte[31]), "32 bytes");
      Check.Throws<ArgumentNullException>(() => new Session(world, (TcpOptions)null), "no options");
      Check.Refused(() => new Session(world, new UdpOptions {Self = 1}), "key");
    }
  }
}
