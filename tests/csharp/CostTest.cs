// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Diagnostics;
using System.Runtime.InteropServices;
using Tandem;

/// <summary>What C# adds to a frame: no garbage, and at most 2 us.</summary>
internal static unsafe class CostTest {
  private const int count = 1000;
  private const double dt = 1.0 / 60.0;

  [DllImport("csharp_loop", CallingConvention = CallingConvention.Cdecl)]
  private static extern void loop_steps(IntPtr world, BodyId* bodies, UIntPtr count,
                                        BodyState* states, int times);

  internal static void Run() {
    NoGarbage();
    StepsCostWhatTheyDoInC();
  }

  /// <summary>10 000 steps with all that a frame may ask.</summary>
  private static void NoGarbage() {
    var def = WorldDef.Default;
    def.Events = true;
    using (var network = new Network(new Link {Latency = 0.03}, 1, Site.Start))
    using (var world = new World(def))
    using (var query = new Query(world))
    using (var peer = new Peer(world, network.Transport(1)))
    using (var other = new Site(network.Transport(2), 0)) {
      world.AddBody(BodyType.Static, Shape.Ground(), Pose.Identity);
      var ball = Shape.Sphere(0.5);
      var body = world.AddBody(BodyType.Dynamic, ball, new Pose(0, 0, 1));
      peer.Share("cube", body);
      var grabbed = GrabDef.Default;
      grabbed.Body = SharedId.Of("cube");
      var frame = new Frames {World = world, Query = query, Peer = peer, Other = other.Peer,
                              OtherWorld = other.World, Network = network, Body = body,
                              Ball = ball, Bodies = new[] {body}, Grab = peer.Grab(grabbed)};
      for (var k = 0; k < 100; ++k) frame.Run(k);  // compiled by now
      var before = GC.GetAllocatedBytesForCurrentThread();
      for (var k = 100; k < 10100; ++k) frame.Run(k);
      var allocated = GC.GetAllocatedBytesForCurrentThread() - before;
      Check.That(allocated == 0, $"10 000 frames allocate nothing: {allocated} bytes");
      Check.That(new object[100].Length == 100 && GC.GetAllocatedBytesForCurrentThread() > before,
                 "what is allocated is seen");
    }
  }

  private sealed class Frames {
    internal World World, OtherWorld;
    internal Query Query;
    internal Peer Peer, Other;
    internal Network Network;
    internal BodyId Body;
    internal BodyId[] Bodies;
    internal Shape Ball;
    internal uint Grab;
    private readonly BodyState[] states = new BodyState[1];
    private readonly Contact[] contacts = new Contact[4];
    private readonly Hit[] hits = new Hit[4];
    private readonly QueryHit[] seen = new QueryHit[4];
    private readonly ColliderId[] inside = new ColliderId[4];
    private QueryFilter filter = QueryFilter.Default;

    internal Frames() {
      filter.Accept = collider => true;
    }

    internal void Run(int k) {
      long now = Site.Start + k * Site.StepNs, next = now + Site.StepNs;
      Network.Advance(now);
      Peer.Move(Grab, new Vec3(0.001 * (k % 100), 0, 1), now);
      Peer.BeforeStep(now);
      Other.BeforeStep(now);
      World.Step(dt);
      OtherWorld.Step(dt);
      Peer.AfterStep(next);
      Other.AfterStep(next);
      World.States(Bodies, states);
      World.ApplyForce(Body, new Vec3(0, 0, 1), new Vec3(0, 0, 0));
      World.Contacts(ContactList.Touching, contacts);
      World.Hits(hits);
      Query.Update();
      Query.Ray(new Vec3(0, 0, 9), new Vec3(0, 0, -1), 10, seen, filter);
      Query.Cast(Ball, new Pose(0, 0, 9), new Vec3(0, 0, -1), seen);
      Query.Overlap(Ball, new Pose(0, 0, 1), inside);
      Frame.Unity.To(World.State(Body).Pose);
    }
  }

  /// <summary>The same two calls in a loop of C. Bodies that sleep, so that what is compared is not
  /// lost in what they would cost; the least of many turns, by turns.</summary>
  private static void StepsCostWhatTheyDoInC() {
    using (var world = new World()) {
      var bodies = new BodyId[count];
      world.AddBody(BodyType.Static, Shape.Ground(), Pose.Identity);
      for (var i = 0; i < count; ++i) {
        bodies[i] = world.AddBody(BodyType.Dynamic, Shape.Box(0.5, 0.5, 0.5),
                                  new Pose(2 * (i % 32), 2 * (i / 32), 0.5));
      }
      var states = new BodyState[count];
      for (var i = 0; i < 120; ++i) world.Step(dt);
      Check.That(world.Step(dt).Awake == 0, "all bodies sleep");
      const int times = 50;
      double inC = double.MaxValue, here = double.MaxValue;
      for (var turn = 0; turn < 60; ++turn) {
        inC = Math.Min(inC, Time(() => {
          fixed (BodyId* from = bodies)
          fixed (BodyState* into = states) {
            loop_steps(world.Handle.DangerousGetHandle(), from, (UIntPtr)count, into, times);
          }
        }));
        here = Math.Min(here, Time(() => {
          for (var i = 0; i < times; ++i) {
            world.Step(dt);
            world.States(bodies, states);
          }
        }));
      }
      double added = (here - inC) / times * 1e6, all = inC / times * 1e6;
      Console.WriteLine($"a step of {count} bodies and their states: {all:F1} us in C, " +
                        $"{added:F2} us more in C#");
      Check.That(added <= 2.0, $"C# adds at most 2 us to a step: {added}");
    }
  }

  /// <returns>s</returns>
  private static double Time(Action work) {
    var watch = Stopwatch.StartNew();
    work();
    return watch.Elapsed.TotalSeconds;
  }
}
