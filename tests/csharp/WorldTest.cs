// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Linq;
using Tandem;

/// <summary>Each case claims something that its physics says by itself.</summary>
internal static class WorldTest {
  private const double dt = 1.0 / 60.0;

  internal static void Run() {
    PushesChangeMotion();
    ManyAreWhereEachIs();
    ConesLieWhereTheyWerePut();
    ABallComesToRest();
    ASensorSeesAVisitor();
    JointsHoldAndTurn();
    SnapshotsGoOnAsBefore();
    ShapesWeighWhatTheyAre();
    WhatIsWrongIsRefused();
  }

  internal static World Weightless() {
    var def = WorldDef.Default;
    def.Gravity = Vec3.Zero;
    return new World(def);
  }

  private static void PushesChangeMotion() {
    using (var world = Weightless()) {
      var body = world.AddBody(BodyDef.Default);  // 1 kg, 0.4 kg m^2
      world.ApplyForce(body, new Vec3(3, 0, 0));
      world.ApplyTorque(body, new Vec3(0, 0, 6));
      for (var i = 0; i < 2; ++i) world.Step(dt);  // in the first alone
      Check.Near(world.State(body).Twist.Linear.X, 3 * dt, 1e-12, "speed of a push");
      Check.Near(world.State(body).Twist.Angular.Z, 6 * dt / 0.4, 1e-9, "spin of a torque");
      world.SetTwist(body, default(Twist));
      world.SetPose(body, Pose.Identity);
      world.ApplyImpulse(body, new Vec3(2, 0, 0), new Vec3(0, 1, 0));
      Check.Near(world.State(body).Twist.Linear.X, 2, 1e-12, "speed of a blow");
      Check.Near(world.State(body).Twist.Angular.Z, -2 / 0.4, 1e-12, "spin of a blow aside");
      world.SetGravity(new Vec3(0, 0, -1));
      Check.That(world.Awake(body) && world.Exists(body), "a body that was pushed is awake");
    }
  }

  private static void ManyAreWhereEachIs() {
    using (var world = Weightless()) {
      var bodies = new BodyId[9];
      for (var i = 0; i < bodies.Length; ++i) {
        var def = BodyDef.Default;
        def.Type = i == 0 ? BodyType.Kinematic : BodyType.Dynamic;
        def.Pose = new Pose(i, 0, 0);
        def.Twist = new Twist(new Vec3(0, 0, i), Vec3.Zero);
        bodies[i] = world.AddBody(def);
      }
      world.MoveTo(bodies[0], new Pose(1, 0.5, 0));
      var report = world.Step(dt);
      Check.That(report.Finite && report.Bodies == 9, "what a step reports");
      var states = new BodyState[12];
      states[8].Pose.Position.X = -1;
      world.States(bodies, 8, states);
      for (var i = 0; i < 8; ++i) {
        Check.That(states[i].Equals(world.State(bodies[i])), $"body {i} of many");
      }
      Check.Near(states[0].Pose.Position.Y, 0.5, 1e-12, "where a kinematic body was sent");
      Check.Near(states[7].Pose.Position.Z, 7 * dt, 1e-12, "where one flies");
      Check.Near(states[8].Pose.Position.X, -1, 0.0, "what lies behind those asked for");
      Check.Refused(() => world.States(bodies, 10, states), "count must be 0 to 9");
      Check.Refused(() => world.States(bodies, new BodyState[8]), "count must be 0 to 8");
      world.RemoveBody(bodies[3]);
      Check.That(!world.Exists(bodies[3]), "a removed body does not exist");
      Check.That(world.AddBody(BodyDef.Default) != bodies[3], "no body has a removed one's handle");
      Check.Refused(() => world.State(bodies[3]), "body");
    }
  }

  /// <summary>The centre of mass of a cone of height h lies h / 4 above its base.</summary>
  private static void ConesLieWhereTheyWerePut() {
    using (var world = Weightless()) {
      var cone = Shape.Cone(0.5, 1.0);
      var half = Quat.About(new Vec3(1, 0, 0), Math.PI);
      var body = world.AddBody(BodyType.Dynamic, cone, new Pose(new Vec3(0, 0, 3), half));
      Check.Near(world.State(body).Pose.Position.Z, 3.5, 1e-12, "centre of mass of a cone upside down");
      using (var query = new Query(world)) {
        Check.That(query.Ray(new Vec3(0, 0, 9), new Vec3(0, 0, -1), 20, out var hit), "a cone is hit");
        Check.Near(hit.Distance, 5, 1e-6, "distance of its base");
      }
    }
  }

  private static void ABallComesToRest() {
    var def = WorldDef.Default;
    def.Events = true;
    using (var world = new World(def)) {
      var ground = world.AddBody(BodyType.Static, Shape.Ground(), Pose.Identity);
      var ball = world.AddBody(BodyType.Dynamic, Shape.Sphere(0.5), new Pose(0, 0, 1));
      var hits = new Hit[4];
      int begun = 0, struck = 0;
      for (var i = 0; i < 240; ++i) {
        world.Step(dt);
        begun += world.Contacts(ContactList.Begun, null);
        for (var k = world.Hits(hits) - 1; k >= 0; --k, ++struck) {
          Check.Near(hits[k].Speed, Math.Sqrt(2 * 9.81 * 0.5), 0.1, "speed of half a metre's fall");
          Check.Near(Math.Abs(hits[k].Normal.Z), 1, 1e-9, "normal of the ground");
        }
      }
      var touching = new Contact[1];
      Check.That(begun == 1 && struck == 1, $"one contact begins, one is hard: {begun}, {struck}");
      Check.That(world.Contacts(ContactList.Touching, touching) == 1, "one goes on");
      Check.That(new[] {touching[0].BodyA, touching[0].BodyB}.OrderBy(b => b.Index).SequenceEqual(
                     new[] {ground, ball}.OrderBy(b => b.Index)),
                 "it names both");
      Check.Near(world.State(ball).Pose.Position.Z, 0.5, 1e-3, "height of a ball at rest");
      Check.That(!world.Awake(ball), "it sleeps");
    }
  }

  private static void ASensorSeesAVisitor() {
    var def = WorldDef.Default;
    def.Events = true;
    using (var world = new World(def)) {
      var still = BodyDef.Default;
      still.Type = BodyType.Static;
      var gate = ColliderDef.Of(world.AddBody(still), Shape.Sphere(0.5));
      gate.Sensor = true;
      var sensor = world.AddCollider(gate);
      world.AddBody(BodyType.Dynamic, Shape.Sphere(0.5), new Pose(0, 0, 2));
      var visits = new Contact[1];
      int came = 0, went = 0;
      for (var i = 0; i < 120; ++i) {
        world.Step(dt);
        if (world.Contacts(ContactList.SensorBegun, visits) == 1) {
          ++came;
          Check.That(visits[0].ColliderA == sensor, "the sensor is a visit's first");
        }
        went += world.Contacts(ContactList.SensorEnded, null);
      }
      Check.That(came == 1 && went == 1, "a visitor comes and goes once");
      world.RemoveCollider(sensor);
      Check.Refused(() => world.RemoveCollider(sensor), "collider");
    }
  }

  private static void JointsHoldAndTurn() {
    using (var world = Weightless()) {
      var wheel = world.AddBody(BodyDef.Default);
      var def = JointDef.Of(JointKind.Hinge);
      def.B = wheel;
      var joint = world.AddJoint(def);
      world.SetMotor(joint, MotorMode.Velocity, 0.5, 100);
      for (var i = 0; i < 120; ++i) world.Step(dt);
      Check.Near(world.JointPosition(joint), 1, 0.02, "angle after 2 s at 0.5 rad/s");
      world.SetServo(joint, MotorMode.Position, 0.3, 40, 8, 50);
      for (var i = 0; i < 180; ++i) world.Step(dt);
      Check.Near(world.JointPosition(joint), 0.3, 1e-2, "angle that a servo holds");
      Check.That(!world.JointBroken(joint), "it holds");
      world.RemoveJoint(joint);
      Check.Refused(() => world.JointPosition(joint), "joint");

      var weak = JointDef.Of(JointKind.Fixed);
      weak.B = world.AddBody(BodyDef.Default);
      weak.BreakForce = 10;
      var breaks = world.AddJoint(weak);
      world.ApplyForce(weak.B, new Vec3(1000, 0, 0));
      world.Step(dt);
      Check.That(world.JointBroken(breaks), "1000 N break what bears 10");
    }
  }

  private static void SnapshotsGoOnAsBefore() {
    using (var world = new World()) {
      world.AddBody(BodyType.Static, Shape.Ground(), Pose.Identity);
      world.AddBody(BodyType.Dynamic, Shape.Box(0.5, 0.4, 0.3), new Pose(0.1, 0, 0.7));
      for (var i = 0; i < 20; ++i) world.Step(dt);
      var bytes = world.Snapshot();
      for (var i = 0; i < 20; ++i) world.Step(dt);
      var after = world.Hash;
      world.Restore(bytes);
      Check.That(world.Hash != after, "a world goes back");
      for (var i = 0; i < 20; ++i) world.Step(dt);
      Check.That(world.Hash == after, "and on by the same bits");
      var buffer = new byte[bytes.Length + 100];
      var kept = buffer;
      var size = world.Snapshot(ref buffer);
      Check.That(ReferenceEquals(kept, buffer) && size <= bytes.Length + 100,
                 "a buffer that is long enough is used");
      world.Restore(buffer, size);
      Check.Refused(() => world.Restore(new byte[8]), "");
      Check.Refused(() => world.Restore(null), "");
      Check.Refused(() => world.Restore(bytes, bytes.Length + 1), "size must be");
    }
  }

  private static void ShapesWeighWhatTheyAre() {
    Check.Near(Shape.Box(0.5, 1, 1.5).Mass(2).Mass, 12, 1e-12, "mass of a box");
    Check.Near(Shape.Box(0.5, 1, 1.5).Mass(2).Inertia.XX, 13, 1e-9, "its inertia");
    Check.Near(Shape.Sphere(1).Mass(3).Mass, 4 * Math.PI, 1e-9, "mass of a sphere");
    Check.Near(Shape.Cylinder(1, 0.5).Mass(1).Mass, Math.PI, 1e-9, "mass of a cylinder");
    Check.Near(Shape.Capsule(1, 0.5).Mass(3).Mass, 7 * Math.PI, 1e-9, "mass of a capsule");
    var corners = new[] {new Vec3(0, 0, 0), new Vec3(1, 0, 0), new Vec3(0, 1, 0), new Vec3(0, 0, 1)};
    var hull = Shape.Hull(corners).Mass(6);
    Check.Near(hull.Mass, 1, 1e-12, "a sixth of a cube");
    Check.Near(hull.CentreOfMass.X, 0.25, 1e-12, "its centre of mass");
    using (var world = new World()) {
      var land = Shape.Heights(3, 3, 4, 4, new double[9]);
      var floor = Shape.Mesh(new[] {new Vec3(16, -4, 0), new Vec3(24, -4, 0), new Vec3(20, 4, 0)},
                             new uint[] {0, 1, 2});
      world.AddBody(BodyType.Static, land, Pose.Identity);
      world.AddBody(BodyType.Static, floor, Pose.Identity);
      var first = world.AddBody(BodyType.Dynamic, Shape.Sphere(0.5), new Pose(0.5, 0.5, 1));
      var second = world.AddBody(BodyType.Dynamic, Shape.Sphere(0.5), new Pose(20, -1, 1));
      for (var i = 0; i < 240; ++i) world.Step(dt);
      Check.Near(world.State(first).Pose.Position.Z, 0.5, 1e-3, "height on a field");
      Check.Near(world.State(second).Pose.Position.Z, 0.5, 1e-3, "height on a mesh");
      Check.Refused(() => Shape.Mesh(corners, new uint[] {0, 1}), "three indices");
      Check.Refused(() => Shape.Heights(3, 3, 1, 1, new double[8]), "3 x 3");
      var wrong = Shape.Mesh(corners, new uint[] {0, 1, 9});
      Check.Refused(() => world.AddBody(BodyType.Static, wrong, Pose.Identity), "9");
    }
  }

  private static void WhatIsWrongIsRefused() {
    var def = WorldDef.Default;
    def.Substeps = 0;
    Check.Refused(() => new World(def), "substeps");
    using (var world = new World()) {
      Check.Refused(() => world.Step(0), "dt");
      var body = BodyDef.Default;
      body.Mass = -1;
      Check.Refused(() => world.AddBody(body), "mass");
      var before = world.Step(dt).Bodies;
      Check.Refused(() => world.AddBody(BodyType.Static, Shape.Sphere(-1), Pose.Identity), "radius");
      Check.That(world.Step(dt).Bodies == before, "what failed has left no body behind");
      Check.Throws<ArgumentNullException>(
          () => world.AddBody(BodyType.Static, null, Pose.Identity), "no shape");
      world.Dispose();
      world.Dispose();  // nothing happens
      Check.Throws<ObjectDisposedException>(() => world.Step(dt), "a world that was disposed of");
    }
  }
}
