// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System.Runtime.InteropServices;

namespace Tandem {

/// <summary>As for a collider.</summary>
[StructLayout(LayoutKind.Sequential)]
public struct CollisionFilter {
  public uint Category, Mask;  // 1, all
  public int Group;            // 0: cars, ropes, cloth and ragdolls get one of their own
}

[StructLayout(LayoutKind.Sequential)]
public struct CharacterDef {
  public double Radius, HalfHeight;  // m, of the capsule, without caps; 0.3, 0.6
  public Vec3 Position;              // m, world, of its centre; (0, 0, 1)
  public double Mass;                // kg; 70
  public double MaxPush;             // N, against obstacles; 400
  public double MaxSlope;            // rad, 0 to 1.5: it slides down steeper ground; 0.87
  public double MaxStep;             // m, up and down while staying on the ground; 0.35
  public double AirAcceleration;     // m/s^2, of the user's control in the air; 10
  public double Padding;             // m, below the radius: gap to everything; 0.02
  public CollisionFilter Filter;

  public static CharacterDef Default {
    get {
      Native.tandem_character_def_init(out var def);
      return def;
    }
  }
}

public enum Footing {
  OnGround = 0,
  OnSteep = 1,  // slides down a slope above MaxSlope
  InAir = 2
}

[StructLayout(LayoutKind.Sequential)]
public struct CharacterState {
  public BodyId Body;
  public Footing Footing;    // after the last Walk
  public BodyId Ground;      // the body below it; in the air BodyId.None
  public Vec3 GroundNormal;  // unit, world; up in the air
  public Vec3 Velocity;      // m/s, world, including that of the ground
}

/// <summary>Its frame is the chassis': x forward, y left, z up.</summary>
[StructLayout(LayoutKind.Sequential)]
public struct CarDef {
  public Pose Pose;           // of the chassis; at (0, 0, 0.8)
  public Vec3 HalfExtents;    // m, of the chassis; (2, 0.8, 0.25)
  public double Mass;         // kg, without wheels; 1200
  public double Wheelbase;    // m, between the axles; 2.6
  public double Track;        // m, between the wheels of an axle; 1.5
  public double AxleHeight;   // m, of the axles in the frame, springs at rest; -0.4
  public double WheelRadius;  // m; 0.35
  public double WheelWidth;   // m; 0.2
  public double WheelMass;    // kg; 20
  public double Stiffness;    // N/m, of each wheel's spring; 30e3
  public double Damping;      // N s/m; 3e3
  public double Travel;       // m, either way from rest; 0.25
  public double Friction;     // of tyres; 0.9
  public double DriveTorque;  // N m, in total; 1600
  public double BrakeTorque;  // N m, in total; 8000
  public double TopSpeed;     // m/s, limits the wheels' spin; 40
  public double MaxSteer;     // rad, 0 to 1.5; 0.6
  public CollisionFilter Filter;

  public static CarDef Default {
    get {
      Native.tandem_car_def_init(out var def);
      return def;
    }
  }
}

/// <summary>Attaches a particle of a rope or a cloth to a body.</summary>
[StructLayout(LayoutKind.Sequential)]
public struct Attachment {
  public ulong Number;  // never reused; 0 = none
}

[StructLayout(LayoutKind.Sequential)]
public struct RopeDef {
  public Vec3 From, To;       // m, world; (0, 0, 0), (1, 0, 0)
  public double Length;       // m, at least their distance; 0 = their distance; 0
  public int Particles;       // at least 2, ends included; odd for a hanging rope; 20
  public double Mass;         // kg, in total; 0.5
  public double Radius;       // m: particles collide as spheres of this size; 0.01
  public double Compliance;   // 1/N: strain per newton; 0
  public double Bending;      // N m^2: moment per curvature; 0
  public double Damping;      // 1/s, air drag; 0.1
  public double Friction, Restitution;  // 0.5, 0
  public CollisionFilter Filter;

  public static RopeDef Default {
    get {
      Native.tandem_rope_def_init(out var def);
      return def;
    }
  }
}

/// <summary>Its frame is that of a flat rectangle with a corner at the origin: columns along x,
/// rows along y.</summary>
[StructLayout(LayoutKind.Sequential)]
public struct ClothDef {
  public Pose Pose;
  public double Width, Height;  // m, along x and y; 1, 1
  public int Columns, Rows;     // particles along x and y, at least 2; 20, 20
  public double Density;        // kg/m^2; 0.2
  public double Radius;         // m: particles collide as spheres of this size; 0.01
  public double Stretching;     // N/m, along the threads; 0 = rigid; 0
  public double Shearing;       // N/m, along the diagonals; 0 = none; 50
  public double Bending;        // N m: moment per metre of width and curvature; 1e-4
  public double Damping;        // 1/s, air drag; 0.2
  public double Friction, Restitution;  // 0.5, 0
  public CollisionFilter Filter;

  public static ClothDef Default {
    get {
      Native.tandem_cloth_def_init(out var def);
      return def;
    }
  }
}

/// <summary>Its frame is between the feet: x forward, y left, z up.</summary>
[StructLayout(LayoutKind.Sequential)]
public struct RagdollDef {
  public Pose Pose;
  public double Height;   // m; 1.75
  public double Mass;     // kg, in total; 70
  public double Damping;  // N m s/rad, of each joint; 2
  public double Friction, Restitution;  // 0.5, 0
  public CollisionFilter Filter;

  public static RagdollDef Default {
    get {
      Native.tandem_ragdoll_def_init(out var def);
      return def;
    }
  }
}

}  // namespace Tandem
