// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System.Runtime.InteropServices;

#pragma warning disable 0649  // the library writes to them

// Structs that a program fills in. Take Default (or Of) and change it, so that fields unknown to
// the program have their defaults.
namespace Tandem {

[StructLayout(LayoutKind.Sequential)]
public struct WorldDef {
  public Vec3 Gravity;       // m/s^2; (0, 0, -9.81)
  public int Substeps;       // per step, 1 to 1000; 4
  public int Threads;        // 1 to 64; 1. Any number gives the same bits.
  public double SleepAfter;  // s; 0.5; 0 = never
  private int events;

  /// <summary>Whether contact events are collected; false.</summary>
  public bool Events { get => events != 0; set => events = value ? 1 : 0; }

  public static WorldDef Default {
    get {
      Native.tandem_world_def_init(out var def);
      return def;
    }
  }
}

[StructLayout(LayoutKind.Sequential)]
public struct StepReport {
  private int finite;
  public int Bodies;
  public int Awake;
  public int Targets;  // bodies pulled by remote states

  /// <summary>False: a body became NaN or infinite and was reset.</summary>
  public bool Finite => finite != 0;
}

public enum BodyType {
  Static = 0,
  Kinematic = 1,  // moves with the given twist
  Dynamic = 2
}

[StructLayout(LayoutKind.Sequential)]
public struct BodyDef {
  public BodyType Type;  // Dynamic
  public Pose Pose;      // of the centre of mass
  public Twist Twist;
  public double Mass;          // kg, > 0; 1
  public Mat3 Inertia;         // kg m^2, body frame, about the centre of mass; 0.4 I
  public double GravityScale;  // 1
  public double LinearDamping, AngularDamping;  // 1/s
  private int bullet;
  private int canSleep;

  /// <summary>Continuous collision detection; false.</summary>
  public bool Bullet { get => bullet != 0; set => bullet = value ? 1 : 0; }
  /// <summary>True.</summary>
  public bool CanSleep { get => canSleep != 0; set => canSleep = value ? 1 : 0; }

  public static BodyDef Default {
    get {
      Native.tandem_body_def_init(out var def);
      return def;
    }
  }
}

[StructLayout(LayoutKind.Sequential)]
public struct MassProperties {
  public double Mass;        // kg
  public Vec3 CentreOfMass;  // m, frame of the shape
  public Mat3 Inertia;       // kg m^2, about the centre of mass
}

public enum JointKind {
  Fixed = 0,
  Ball = 1,
  Hinge = 2,  // turns about the axis
  Slider = 3  // moves along the axis
}

public enum MotorMode { Off = 0, Velocity = 1, Position = 2 }

/// <summary>Frames are attached at the bodies' present poses; all coordinates are 0
/// there.</summary>
[StructLayout(LayoutKind.Sequential)]
public struct JointDef {
  public JointKind Kind;
  public BodyId A, B;        // A may be BodyId.None, the world
  public Vec3 Anchor;        // m, world
  public Vec3 Axis;          // world; hinges and sliders; (1, 0, 0)
  public double Compliance;  // m/N, of the locked coordinates, 0 = rigid; 0
  private int limited;
  public double Lower, Upper;  // rad of hinges, m of sliders
  public MotorMode Motor;
  public double MotorTarget, MotorMaxForce;  // 0; infinite
  public double BreakForce, BreakTorque;     // N, N m; 0 = never

  /// <summary>Hinges and sliders: between Lower and Upper; false.</summary>
  public bool Limited { get => limited != 0; set => limited = value ? 1 : 0; }

  public static JointDef Of(JointKind kind) {
    Native.tandem_joint_def_init(out var def, kind);
    return def;
  }
}

[StructLayout(LayoutKind.Sequential)]
public struct Contact {
  public ColliderId ColliderA, ColliderB;
  public BodyId BodyA, BodyB;
}

/// <summary>A contact that begins faster than 1 m/s.</summary>
[StructLayout(LayoutKind.Sequential)]
public struct Hit {
  public Contact Contact;
  public Vec3 Point;      // m, world
  public Vec3 Normal;     // unit, world, from A to B
  public double Speed;    // m/s, of approach
  public double Impulse;  // N s
}

public enum ContactList {
  Begun = 0,
  Ended = 1,
  Touching = 2,
  SensorBegun = 3,  // A is the sensor
  SensorEnded = 4,
  InSensor = 5
}

[StructLayout(LayoutKind.Sequential)]
public struct QueryHit {
  public ColliderId Collider;
  public BodyId Body;
  public Vec3 Point;       // m, world, on the collider
  public Vec3 Normal;      // unit, world, out of the collider
  public double Distance;  // m: along a ray; to the closest point; below 0: overlap
  public double Fraction;  // along a ray or a cast, 0 to 1; else 0
  public uint Triangle;    // of a mesh; else 0xffffffff
}

public enum Delivery {
  Newest = 0,   // may be lost
  Reliable = 1  // in order, all of them
}

/// <summary>A link between two peers of a Network.</summary>
[StructLayout(LayoutKind.Sequential)]
public struct Link {
  public double Latency, Jitter;  // s, one way
  public double Loss;             // probability that a state is lost
  public double Bandwidth;        // bit/s; 0 = unlimited
}

[StructLayout(LayoutKind.Sequential)]
public struct PeerDef {
  public double UpdateHz;       // states sent per second; 60
  public double Influence;      // fraction of a difference closed per 1/60 s; 0.08
  public double AuthorityRamp;  // s, over which a newcomer gains influence; 1
  private int compact;
  public double Tolerance;     // m: largest prediction error not corrected; 0 = send all
  public double KbitPerS;      // largest rate to each peer; 0 = no limit
  public double ReplayBudget;  // replayed steps allowed per step, at least 1; 4

  /// <summary>States are rounded (0.12 mm) and take about 27 bytes, not 93; false.</summary>
  public bool Compact { get => compact != 0; set => compact = value ? 1 : 0; }

  public static PeerDef Default {
    get {
      Native.tandem_peer_def_init(out var def);
      return def;
    }
  }
}

[StructLayout(LayoutKind.Sequential)]
public struct GrabDef {
  public SharedId Body;
  public Vec3 Attachment;                       // m, frame of the body
  public Vec3 Anchor;                           // m, world: the hand
  public double Stiffness, Damping, MaxForce;  // N/m, N s/m, N; 500, 20, 1e6

  public static GrabDef Default {
    get {
      Native.tandem_grab_def_init(out var def);
      return def;
    }
  }
}

/// <summary>An instantaneous act on a shared body: pose and twist change only if set, impulses are
/// added.</summary>
[StructLayout(LayoutKind.Sequential)]
public struct ActDef {
  public SharedId Body;
  public Vec3 Impulse;         // N s, world, at the centre of mass
  public Vec3 AngularImpulse;  // N m s, world
  private int setsPose;
  private int setsTwist;
  private Pose pose;
  private Twist twist;
  public ulong Name;  // acts on a body under one name within 1 s count once, by any peer; 0 = none

  /// <summary>Null: unchanged.</summary>
  public Pose? Pose {
    get => setsPose != 0 ? pose : (Pose?)null;
    set {
      setsPose = value.HasValue ? 1 : 0;
      pose = value ?? Tandem.Pose.Identity;
    }
  }

  /// <summary>Null: unchanged.</summary>
  public Twist? Twist {
    get => setsTwist != 0 ? twist : (Twist?)null;
    set {
      setsTwist = value.HasValue ? 1 : 0;
      twist = value.GetValueOrDefault();
    }
  }

  public static ActDef Default {
    get {
      Native.tandem_act_def_init(out var def);
      return def;
    }
  }
}

[StructLayout(LayoutKind.Sequential)]
public struct PeerStats {
  public ulong UpdatesReceived, PacketsReceived, PacketsRejected, BytesSent, BodiesPlaced;
}

}  // namespace Tandem
