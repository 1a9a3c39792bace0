// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#if UNITY_5_3_OR_NEWER
using UnityEngine;

namespace Tandem {

/// <summary>Converts between Unity's types and axes and ours (Frame.Unity). A body's Transform must
/// not have a scaled parent.</summary>
public static class UnityConversions {
  public static Vector3 ToUnity(this Vec3 v) => Vector(Frame.Unity.To(v));
  public static Vec3 ToTandem(this Vector3 v) => Frame.Unity.From(Vector(v));

  /// <summary>Angular velocities, torques, axes of hinges.</summary>
  public static Vector3 ToUnityTurning(this Vec3 v) => Vector(Frame.Unity.ToTurning(v));
  public static Vec3 ToTandemTurning(this Vector3 v) => Frame.Unity.FromTurning(Vector(v));

  public static Quaternion ToUnity(this Quat q) {
    var to = Frame.Unity.To(q);
    return new Quaternion((float)to.X, (float)to.Y, (float)to.Z, (float)to.W);
  }

  /// <summary>Normalised, as Unity's are unit in single precision only.</summary>
  public static Quat ToTandem(this Quaternion q) {
    var from = Frame.Unity.From(new Quat(q.x, q.y, q.z, q.w));
    var s = 1.0 / System.Math.Sqrt(from.X * from.X + from.Y * from.Y + from.Z * from.Z +
                                   from.W * from.W);
    return new Quat(s * from.X, s * from.Y, s * from.Z, s * from.W);
  }

  /// <summary>Half extents of a box whose edges are `size` (m) in Unity.</summary>
  public static Vec3 ToHalfExtents(this Vector3 size) => Frame.Unity.Size(0.5 * Vector(size));

  /// <summary>Pose of a Transform.</summary>
  public static Pose ToTandem(this Transform transform) =>
      new Pose(transform.position.ToTandem(), transform.rotation.ToTandem());

  /// <summary>Moves a Transform to a body's pose.</summary>
  public static void Show(this Transform transform, Pose pose) =>
      transform.SetPositionAndRotation(pose.Position.ToUnity(), pose.Orientation.ToUnity());

  private static Vector3 Vector(Vec3 v) => new Vector3((float)v.X, (float)v.Y, (float)v.Z);
  private static Vec3 Vector(Vector3 v) => new Vec3(v.x, v.y, v.z);
}

}  // namespace Tandem
#endif
