// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System.Collections.Generic;
using System.Linq;
using Tandem;

/// <summary>The programs of reference.c once more: their bits are the same.</summary>
internal static class HashTest {
  internal static void Run(string[] reference) {
    Compare(reference, "falling", Falling());
    Compare(reference, "stack", Stack());
  }

  private static void Compare(string[] reference, string name, List<ulong> hashes) {
    var start = $"hash {name} ";
    var expected = reference.Where(line => line.StartsWith(start))
                       .Select(line => ulong.Parse(line.Substring(start.Length)))
                       .ToList();
    Check.That(expected.Count > 3 && expected.Distinct().Count() > 2, $"{name} moves in C");
    Check.That(expected.SequenceEqual(hashes),
               $"{name} has the hashes {string.Join(" ", expected)} of C, not {string.Join(" ", hashes)}");
  }

  /// <summary>docs/tutorial.md.</summary>
  private static List<ulong> Falling() {
    var hashes = new List<ulong>();
    using (var world = new World()) {
      world.AddBody(BodyType.Static, Shape.Ground(), Pose.Identity);
      world.AddBody(BodyType.Dynamic, Shape.Box(0.1, 0.1, 0.1), new Pose(0, 0, 1), 250.0);
      for (var i = 0; i <= 120; ++i) {
        if (i % 30 == 0) hashes.Add(world.Hash);
        world.Step(1.0 / 60.0);
      }
    }
    return hashes;
  }

  private static List<ulong> Stack() {
    var hashes = new List<ulong>();
    using (var world = new World()) {
      world.AddBody(BodyType.Static, Shape.Ground(), Pose.Identity);
      var box = Shape.Box(0.2, 0.15, 0.1);
      for (var i = 0; i < 8; ++i) {
        world.AddBody(BodyType.Dynamic, box, new Pose(0.01 * i, -0.02 * i, 0.1 + 0.21 * i), 400.0);
      }
      var leaf = world.AddBody(BodyType.Dynamic, Shape.Capsule(0.1, 0.4), new Pose(0.8, 0.6, 0.7),
                               700.0);
      var def = JointDef.Of(JointKind.Hinge);
      def.B = leaf;
      def.Anchor = new Vec3(1.2, 0.6, 0.7);
      def.Axis = new Vec3(0, 0, 1);
      def.Motor = MotorMode.Velocity;
      def.MotorTarget = 2.0;
      def.MotorMaxForce = 300.0;
      world.AddJoint(def);
      for (var i = 0; i < 240; ++i) {
        world.Step(1.0 / 60.0);
        if (i % 60 == 59) hashes.Add(world.Hash);
      }
    }
    return hashes;
  }
}
