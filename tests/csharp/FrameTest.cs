// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using Tandem;

/// <summary>Conversions between axes by what they have to keep.</summary>
internal static class FrameTest {
  private static readonly Random random = new Random(7);

  internal static void Run() {
    for (var i = 0; i < 100; ++i) {
      Holds(Frame.Unity, -1.0);
      Holds(Frame.Godot, 1.0);
    }
    // Forward and up, as the engines' manuals name them.
    Close(Frame.Unity.To(new Vec3(0, 0, 1)), new Vec3(0, 1, 0), "up in Unity");
    Close(Frame.Unity.To(new Vec3(0, 1, 0)), new Vec3(0, 0, 1), "forward in Unity");
    Close(Frame.Godot.To(new Vec3(0, 0, 1)), new Vec3(0, 1, 0), "up in Godot");
    Close(Frame.Godot.To(new Vec3(0, 1, 0)), new Vec3(0, 0, -1), "forward in Godot");
    Close(Frame.Unity.Size(new Vec3(1, 2, 3)), new Vec3(1, 3, 2), "a size");
  }

  /// <param name="hand">what the determinant of the change of axes is</param>
  private static void Holds(Frame frame, double hand) {
    Vec3 a = Vector(), b = Vector();
    Quat p = Rotation(), q = Rotation();
    Close(frame.From(frame.To(a)), a, "a vector there and back");
    Close(frame.FromTurning(frame.ToTurning(a)), a, "an angular velocity there and back");
    Check.That(frame.From(frame.To(q)).Equals(q), "a rotation there and back");
    var pose = frame.From(frame.To(new Pose(a, q)));
    Check.That(pose.Position.Equals(a) && pose.Orientation.Equals(q), "a pose there and back");
    var twist = frame.From(frame.To(new Twist(a, b)));
    Check.That(twist.Linear.Equals(a) && twist.Angular.Equals(b), "a twist there and back");

    Check.Near(Vec3.Dot(frame.To(a), frame.To(b)), Vec3.Dot(a, b), 1e-12, "an angle");
    // The formula of the cross product turns with the hand: x cross y = z in both, by another hand.
    Close(Vec3.Cross(frame.To(a), frame.To(b)), hand * frame.To(Vec3.Cross(a, b)), "a hand");
    // v = w x r, with each engine's own product.
    Close(frame.To(Vec3.Cross(a, b)), Vec3.Cross(frame.ToTurning(a), frame.To(b)),
          "the velocity of a place on a turning body");

    Close(frame.To(q) * frame.To(a), frame.To(q * a), "rotated, then converted");
    Same(frame.To(p) * frame.To(q), frame.To(p * q), "one rotation after another");
    var axis = (1.0 / a.Length) * a;
    var angle = random.NextDouble();
    Same(frame.To(Quat.About(axis, angle)), Quat.About(frame.ToTurning(axis), angle),
         "an angle about an axis");
    // A body that turns at w for a short time t has turned by about w t.
    const double t = 1e-6;
    var turned = Quat.About(axis, b.Length * t);
    var there = frame.ToTurning(b.Length * axis);
    Close((1.0 / t) * Rate(frame.To(turned)), there, "a rate of turning", 1e-9);
  }

  private static Vec3 Rate(Quat q) => 2.0 * new Vec3(q.X, q.Y, q.Z);

  private static double Number() => 2.0 * random.NextDouble() - 1.0;

  private static Vec3 Vector() => new Vec3(Number(), Number(), Number());

  private static Quat Rotation() {
    var v = Vector();
    return Quat.About((1.0 / v.Length) * v, 6.0 * Number());
  }

  private static void Close(Vec3 value, Vec3 expected, string what, double tolerance = 1e-12) =>
      Check.That((value - expected).Length <= tolerance, $"{what}: {value} is {expected}");

  private static void Same(Quat value, Quat expected, string what) => Check.That(
      Math.Abs(value.X - expected.X) + Math.Abs(value.Y - expected.Y) +
              Math.Abs(value.Z - expected.Z) + Math.Abs(value.W - expected.W) <= 1e-12,
      $"{what}: {value} is {expected}");
}
