// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Linq;
using Tandem;

/// <summary>Characters, cars, ropes, cloth and ragdolls end up where their numbers say.</summary>
internal static class PartTest {
  private const double dt = 1.0 / 60.0;

  internal static void Run() {
    ACharacterWalksAndJumps();
    ACarRollsAsItsWheelsTurn();
    ARopeHangsByItsLength();
    AClothHangsByItsHeight();
    ARagdollFallsOver();
  }

  private static World WithGround() {
    var world = new World();
    var still = BodyDef.Default;
    still.Type = BodyType.Static;
    var ground = ColliderDef.Of(world.AddBody(still), Shape.Ground());
    ground.Friction = 0.9;
    world.AddCollider(ground);
    return world;
  }

  private static void Steps(World world, double seconds) {
    for (var i = 0; i < (int)(seconds / dt + 0.5); ++i) world.Step(dt);
  }

  private static Vec3 At(World world, BodyId body) => world.State(body).Pose.Position;

  private static void ACharacterWalksAndJumps() {
    using (var world = WithGround()) {
      var def = CharacterDef.Default;
      def.Mass = 0;
      Check.Refused(() => new Character(world, def), "mass");
      def = CharacterDef.Default;
      var hero = new Character(world);
      var stands = def.HalfHeight + def.Radius + def.Padding;
      Action<Vec3> walk = velocity => {
        hero.Walk(velocity, dt);
        world.Step(dt);
      };
      for (var i = 0; i < 60; ++i) walk(Vec3.Zero);
      var body = hero.State.Body;
      Check.That(hero.State.Footing == Footing.OnGround, "a character stands");
      Check.Near(At(world, body).Z, stands, 0.01, "height of its middle");
      for (var i = 0; i < 60; ++i) walk(new Vec3(2, 0, 0));
      Check.Near(At(world, body).X, 2, 0.1, "its way in a second at 2 m/s");
      hero.Jump(4);
      var top = 0.0;
      for (var i = 0; i < 60; ++i) {
        walk(Vec3.Zero);
        top = Math.Max(top, At(world, body).Z);
        if (i == 10) {
          Check.That(hero.State.Footing == Footing.InAir && hero.State.Ground == BodyId.None,
                     "who jumps is in the air");
        }
      }
      Check.Near(top - stands, 16 / (2 * 9.81), 0.05, "height of a jump");
      Check.Refused(() => hero.Jump(-1), "speed");
      hero.Dispose();
      Check.That(!world.Exists(body), "a character's body goes with it");
      Check.Throws<ObjectDisposedException>(() => hero.Jump(1), "a character that is gone");
    }
  }

  private static void ACarRollsAsItsWheelsTurn() {
    using (var world = WithGround()) {
      var def = CarDef.Default;
      def.TopSpeed = 10;
      using (var car = new Car(world, def)) {
        var bodies = new BodyId[5];
        Check.That(car.Bodies(null) == 5 && car.Bodies(bodies) == 5, "a chassis and four wheels");
        car.Drive(1, 0, 0);
        Steps(world, 10);
        Check.Near(car.Speed, 10, 0.5, "top speed");
        var begin = At(world, bodies[0]).X;
        Steps(world, 2);
        Check.Near(At(world, bodies[0]).X - begin, 20, 1, "its way in 2 s");
        car.Drive(0, 0, 1);
        Steps(world, 5);
        Check.Near(car.Speed, 0, 0.1, "speed of a car that has braked");
        Check.Refused(() => car.Drive(2, 0, 0), "throttle");
      }
    }
  }

  private static void ARopeHangsByItsLength() {
    using (var world = new World()) {
      var hook = BodyDef.Default;
      hook.Type = BodyType.Static;
      var def = RopeDef.Default;
      def.From = new Vec3(0, 0, 3);
      def.To = new Vec3(1.5, 0, 3);
      def.Damping = 2;
      using (var rope = new Rope(world, def)) {
        var bodies = new BodyId[def.Particles];
        Check.That(rope.Bodies(bodies) == bodies.Length, "its particles");
        var held = rope.Attach(0, world.AddBody(hook));
        Steps(world, 20);
        Check.Near(At(world, bodies.Last()).Z, 1.5, 0.01, "low end of a rope of 1.5 m");
        world.RemoveAttachment(held);
        Check.Refused(() => world.RemoveAttachment(held), "attachment");
        Steps(world, 1);
        Check.That(At(world, bodies[0]).Z < 2, "a rope that is let go falls");
      }
    }
  }

  private static void AClothHangsByItsHeight() {
    using (var world = new World()) {
      var still = BodyDef.Default;
      still.Type = BodyType.Static;
      var rail = world.AddBody(still);
      var def = ClothDef.Default;
      // Its y is down.
      def.Pose = new Pose(new Vec3(0, 0, 3), Quat.About(new Vec3(1, 0, 0), -0.5 * Math.PI));
      def.Width = 0.8;
      def.Height = 1.2;
      def.Columns = 8;
      def.Rows = 12;
      using (var cloth = new Cloth(world, def)) {
        var bodies = new BodyId[96];
        Check.That(cloth.Bodies(bodies) == 96, "its particles");
        for (var i = 0; i < 8; ++i) cloth.Attach(i, 0, rail);
        cloth.Tether();
        var handle = cloth.AddHandle(0.5, 0.5, 0.3, 0.3);
        Steps(world, 5);
        Check.Near(At(world, bodies[95]).Z, 1.8, 0.02, "low edge of a cloth of 1.2 m");
        Check.Near(At(world, handle).Z, 2.4, 0.03, "its middle");
      }
    }
  }

  private static void ARagdollFallsOver() {
    using (var world = WithGround()) {
      var def = RagdollDef.Default;
      def.Height = 2;
      def.Pose.Position.Z = 0.01;
      using (var doll = new Ragdoll(world, def)) {
        var bodies = new BodyId[11];
        Check.That(doll.Bodies(bodies) == 11, "its bodies");
        Check.That(At(world, bodies[2]).Z > 1.7 && At(world, bodies[2]).Z < 2, "its head is on top");
        world.ApplyImpulse(bodies[2], new Vec3(10, 3, 0));
        Steps(world, 5);
        Check.That(bodies.All(body => At(world, body).Z > 0 && At(world, body).Z < 0.6), "it lies");
      }
    }
  }
}
