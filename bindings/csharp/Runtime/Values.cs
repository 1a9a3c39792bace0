// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Runtime.InteropServices;

// Laid out like their namesakes in tandem/c/tandem.h: they are passed without a copy.
namespace Tandem {

[StructLayout(LayoutKind.Sequential)]
public struct Vec3 : IEquatable<Vec3> {
  public double X, Y, Z;

  public Vec3(double x, double y, double z) {
    X = x;
    Y = y;
    Z = z;
  }

  public static Vec3 Zero => default(Vec3);
  public double Length => Math.Sqrt(Dot(this, this));

  public static Vec3 operator +(Vec3 a, Vec3 b) => new Vec3(a.X + b.X, a.Y + b.Y, a.Z + b.Z);
  public static Vec3 operator -(Vec3 a, Vec3 b) => new Vec3(a.X - b.X, a.Y - b.Y, a.Z - b.Z);
  public static Vec3 operator -(Vec3 a) => new Vec3(-a.X, -a.Y, -a.Z);
  public static Vec3 operator *(double s, Vec3 a) => new Vec3(s * a.X, s * a.Y, s * a.Z);
  public static double Dot(Vec3 a, Vec3 b) => a.X * b.X + a.Y * b.Y + a.Z * b.Z;

  public static Vec3 Cross(Vec3 a, Vec3 b) =>
      new Vec3(a.Y * b.Z - a.Z * b.Y, a.Z * b.X - a.X * b.Z, a.X * b.Y - a.Y * b.X);

  public bool Equals(Vec3 other) => X == other.X && Y == other.Y && Z == other.Z;
  public override bool Equals(object other) => other is Vec3 && Equals((Vec3)other);
  public override int GetHashCode() => (X, Y, Z).GetHashCode();
  public override string ToString() => $"({X}, {Y}, {Z})";
}

/// <summary>Unit, body to world.</summary>
[StructLayout(LayoutKind.Sequential)]
public struct Quat : IEquatable<Quat> {
  public double X, Y, Z, W;

  public Quat(double x, double y, double z, double w) {
    X = x;
    Y = y;
    Z = z;
    W = w;
  }

  public static Quat Identity => new Quat(0.0, 0.0, 0.0, 1.0);

  /// <param name="axis">unit</param>
  /// <param name="angle">rad</param>
  public static Quat About(Vec3 axis, double angle) {
    var v = Math.Sin(0.5 * angle) * axis;
    return new Quat(v.X, v.Y, v.Z, Math.Cos(0.5 * angle));
  }

  public Quat Inverse => new Quat(-X, -Y, -Z, W);

  public static Quat operator *(Quat a, Quat b) {
    var u = new Vec3(a.X, a.Y, a.Z);
    var v = new Vec3(b.X, b.Y, b.Z);
    var w = a.W * v + b.W * u + Vec3.Cross(u, v);
    return new Quat(w.X, w.Y, w.Z, a.W * b.W - Vec3.Dot(u, v));
  }

  public static Vec3 operator *(Quat q, Vec3 v) {
    var u = new Vec3(q.X, q.Y, q.Z);
    var t = 2.0 * Vec3.Cross(u, v);
    return v + q.W * t + Vec3.Cross(u, t);
  }

  public bool Equals(Quat other) => X == other.X && Y == other.Y && Z == other.Z && W == other.W;
  public override bool Equals(object other) => other is Quat && Equals((Quat)other);
  public override int GetHashCode() => (X, Y, Z, W).GetHashCode();
  public override string ToString() => $"({X}, {Y}, {Z}, {W})";
}

[StructLayout(LayoutKind.Sequential)]
public struct Pose {
  public Vec3 Position;  // m
  public Quat Orientation;

  public Pose(Vec3 position, Quat orientation) {
    Position = position;
    Orientation = orientation;
  }

  public Pose(double x, double y, double z) : this(new Vec3(x, y, z), Quat.Identity) {}

  public static Pose Identity => new Pose(0.0, 0.0, 0.0);
}

[StructLayout(LayoutKind.Sequential)]
public struct Twist {
  public Vec3 Linear;   // m/s, world
  public Vec3 Angular;  // rad/s, world

  public Twist(Vec3 linear, Vec3 angular) {
    Linear = linear;
    Angular = angular;
  }
}

[StructLayout(LayoutKind.Sequential)]
public struct BodyState {
  public Pose Pose;  // of the centre of mass
  public Twist Twist;
}

/// <summary>Row by row.</summary>
[StructLayout(LayoutKind.Sequential)]
public struct Mat3 {
  public double XX, XY, XZ, YX, YY, YZ, ZX, ZY, ZZ;

  public static Mat3 Diagonal(double x, double y, double z) =>
      new Mat3 {XX = x, YY = y, ZZ = z};
}

/// <summary>A body of a world. The id of a removed body is an error, and never refers to another
/// one.</summary>
[StructLayout(LayoutKind.Sequential)]
public struct BodyId : IEquatable<BodyId> {
  public uint Index, Generation;

  /// <summary>The world, where a joint or an event names a body.</summary>
  public static BodyId None => new BodyId {Index = uint.MaxValue};

  public bool Equals(BodyId other) => Index == other.Index && Generation == other.Generation;
  public override bool Equals(object other) => other is BodyId && Equals((BodyId)other);
  public override int GetHashCode() => (Index, Generation).GetHashCode();
  public static bool operator ==(BodyId a, BodyId b) => a.Equals(b);
  public static bool operator !=(BodyId a, BodyId b) => !a.Equals(b);
}

[StructLayout(LayoutKind.Sequential)]
public struct ColliderId : IEquatable<ColliderId> {
  public uint Index, Generation;

  public bool Equals(ColliderId other) => Index == other.Index && Generation == other.Generation;
  public override bool Equals(object other) => other is ColliderId && Equals((ColliderId)other);
  public override int GetHashCode() => (Index, Generation).GetHashCode();
  public static bool operator ==(ColliderId a, ColliderId b) => a.Equals(b);
  public static bool operator !=(ColliderId a, ColliderId b) => !a.Equals(b);
}

[StructLayout(LayoutKind.Sequential)]
public struct JointId : IEquatable<JointId> {
  public uint Index, Generation;

  public bool Equals(JointId other) => Index == other.Index && Generation == other.Generation;
  public override bool Equals(object other) => other is JointId && Equals((JointId)other);
  public override int GetHashCode() => (Index, Generation).GetHashCode();
  public static bool operator ==(JointId a, JointId b) => a.Equals(b);
  public static bool operator !=(JointId a, JointId b) => !a.Equals(b);
}

/// <summary>A shared body, the same on every machine.</summary>
[StructLayout(LayoutKind.Sequential)]
public struct SharedId : IEquatable<SharedId> {
  public ulong High, Low;

  /// <summary>The id of a name.</summary>
  public static SharedId Of(string name) => Native.tandem_shared_id_of(Native.Text(name));

  public bool Equals(SharedId other) => High == other.High && Low == other.Low;
  public override bool Equals(object other) => other is SharedId && Equals((SharedId)other);
  public override int GetHashCode() => (High, Low).GetHashCode();
  public static bool operator ==(SharedId a, SharedId b) => a.Equals(b);
  public static bool operator !=(SharedId a, SharedId b) => !a.Equals(b);
}

}  // namespace Tandem
