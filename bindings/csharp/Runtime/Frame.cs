// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
namespace Tandem {

/// <summary>Axes of an engine with y up. Ours are right-handed with z up: our z is its y, also for
/// capsules and cylinders.
///
/// Vectors are of two kinds. Positions, velocities and forces use To and From; axial vectors
/// (angular velocities, torques, axes of hinges) use ToTurning and FromTurning, which differ if the
/// engine is left-handed.</summary>
public struct Frame {
  /// <summary>x right, y up, z forward, left-handed: our (x, y, z) is its (x, z, y).</summary>
  public static Frame Unity => new Frame {left = true};
  /// <summary>x right, y up, z back, right-handed: our (x, y, z) is its (x, z, -y).</summary>
  public static Frame Godot => new Frame {left = false};

  private bool left;

  /// <summary>To the engine's axes.</summary>
  public Vec3 To(Vec3 v) => new Vec3(v.X, v.Z, left ? v.Y : -v.Y);
  public Vec3 From(Vec3 v) => new Vec3(v.X, left ? v.Z : -v.Z, v.Y);

  public Vec3 ToTurning(Vec3 v) => left ? -To(v) : To(v);
  public Vec3 FromTurning(Vec3 v) => left ? -From(v) : From(v);

  public Quat To(Quat q) {
    var v = ToTurning(new Vec3(q.X, q.Y, q.Z));
    return new Quat(v.X, v.Y, v.Z, q.W);
  }

  public Quat From(Quat q) {
    var v = FromTurning(new Vec3(q.X, q.Y, q.Z));
    return new Quat(v.X, v.Y, v.Z, q.W);
  }

  public Pose To(Pose pose) => new Pose(To(pose.Position), To(pose.Orientation));
  public Pose From(Pose pose) => new Pose(From(pose.Position), From(pose.Orientation));

  public Twist To(Twist twist) => new Twist(To(twist.Linear), ToTurning(twist.Angular));
  public Twist From(Twist twist) => new Twist(From(twist.Linear), FromTurning(twist.Angular));

  /// <summary>Sizes of boxes and the like, which have no sign. Both ways.</summary>
  public Vec3 Size(Vec3 v) => new Vec3(v.X, v.Z, v.Y);
}

}  // namespace Tandem
