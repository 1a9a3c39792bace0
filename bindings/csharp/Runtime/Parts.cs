// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;

namespace Tandem {

/// <summary>Made of bodies of a world; disposing of it removes them. If the program removes one of
/// its bodies itself, it can only be disposed of.</summary>
public abstract unsafe class Part : IDisposable {
  private readonly World world;
  private NativeHandle handle;

  internal Part(World world) {
    this.world = world ?? throw new ArgumentNullException(nameof(world));
  }

  internal void Adopt(NativeHandle part, IntPtr made, ref NativeError error) {
    part.Adopt(made, ref error, world.Handle);
    handle = part;
    world.Dependents.Add(this);
  }

  public void Dispose() {
    handle.Dispose();
    world.Dependents.Remove(this);
  }

  internal static UIntPtr Capacity(Array into) => (UIntPtr)(into == null ? 0 : into.Length);
}

/// <summary>A capsule that walks, climbs steps and slopes, jumps, is carried, pushes and is
/// pushed.</summary>
public sealed unsafe class Character : Part {
  private readonly CharacterHandle handle = new CharacterHandle();

  public Character(World world) : this(world, CharacterDef.Default) {}

  public Character(World world, CharacterDef def) : base(world) {
    NativeError error;
    Adopt(handle, Native.tandem_character_create(world.Handle, &def, &error), ref error);
  }

  /// <summary>Call before each step.</summary>
  /// <param name="velocity">m/s, wanted, relative to the ground</param>
  /// <param name="dt">s, of the step</param>
  public void Walk(Vec3 velocity, double dt) {
    NativeError error;
    Native.Check(Native.tandem_character_walk(handle, velocity, dt, &error), ref error);
  }

  /// <summary>The next walk leaves the ground, if it stands on some.</summary>
  /// <param name="speed">m/s, >= 0</param>
  public void Jump(double speed) {
    NativeError error;
    Native.Check(Native.tandem_character_jump(handle, speed, &error), ref error);
  }

  public CharacterState State {
    get {
      CharacterState state;
      NativeError error;
      Native.Check(Native.tandem_character_get_state(handle, &state, &error), ref error);
      return state;
    }
  }
}

/// <summary>A chassis on four sprung wheels, all driven and braked, the front ones
/// steered.</summary>
public sealed unsafe class Car : Part {
  private readonly CarHandle handle = new CarHandle();

  public Car(World world, CarDef def) : base(world) {
    NativeError error;
    Adopt(handle, Native.tandem_car_create(world.Handle, &def, &error), ref error);
  }

  /// <summary>Holds until the next call.</summary>
  /// <param name="throttle">-1, backwards, to 1</param>
  /// <param name="steer">rad, to the left, of a virtual wheel between the front ones</param>
  /// <param name="brake">0 to 1; above 0 the drive is off</param>
  public void Drive(double throttle, double steer, double brake) {
    NativeError error;
    Native.Check(Native.tandem_car_drive(handle, throttle, steer, brake, &error), ref error);
  }

  /// <summary>Forward speed of the chassis, m/s; 0 if the chassis was removed.</summary>
  public double Speed => Native.tandem_car_speed(handle);

  /// <summary>The chassis, then the wheels: front left, front right, rear left, rear right. Fills
  /// the array as far as it goes; it may be null.</summary>
  /// <returns>the total number</returns>
  public int Bodies(BodyId[] into) {
    fixed (BodyId* bodies = into) {
      return (int)Native.tandem_car_bodies(handle, bodies, Capacity(into));
    }
  }
}

/// <summary>A rope of point masses, each a body.</summary>
public sealed unsafe class Rope : Part {
  private readonly RopeHandle handle = new RopeHandle();

  public Rope(World world, RopeDef def) : base(world) {
    NativeError error;
    Adopt(handle, Native.tandem_rope_create(world.Handle, &def, &error), ref error);
  }

  /// <summary>The particles, from one end to the other, like Car.Bodies.</summary>
  public int Bodies(BodyId[] into) {
    fixed (BodyId* bodies = into) {
      return (int)Native.tandem_rope_bodies(handle, bodies, Capacity(into));
    }
  }

  /// <summary>Attach a particle at its present place to a body. From then on it collides with
  /// nothing.</summary>
  public Attachment Attach(uint particle, BodyId host) {
    Attachment attachment;
    NativeError error;
    Native.Check(Native.tandem_rope_attach(handle, particle, host, &attachment, &error),
                 ref error);
    return attachment;
  }
}

/// <summary>A rectangle of cloth of point masses, each a body.</summary>
public sealed unsafe class Cloth : Part {
  private readonly ClothHandle handle = new ClothHandle();

  public Cloth(World world, ClothDef def) : base(world) {
    NativeError error;
    Adopt(handle, Native.tandem_cloth_create(world.Handle, &def, &error), ref error);
  }

  /// <summary>The particles, row by row, like Car.Bodies.</summary>
  public int Bodies(BodyId[] into) {
    fixed (BodyId* bodies = into) {
      return (int)Native.tandem_cloth_bodies(handle, bodies, Capacity(into));
    }
  }

  /// <summary>As Rope.Attach.</summary>
  public Attachment Attach(int column, int row, BodyId host) {
    Attachment attachment;
    NativeError error;
    Native.Check(Native.tandem_cloth_attach(handle, column, row, host, &attachment, &error),
                 ref error);
    return attachment;
  }

  /// <summary>Keeps each particle within its distance of the nearest attached one, so that hanging
  /// cloth does not stretch. Call it once, after attaching.</summary>
  public void Tether() {
    NativeError error;
    Native.Check(Native.tandem_cloth_tether(handle, &error), ref error);
  }

  /// <summary>A body at the mean of the cloth around a point, which can be held, pulled and
  /// shared.</summary>
  /// <param name="u">0 to 1, along columns</param>
  /// <param name="v">0 to 1, along rows</param>
  /// <param name="reach">m, above the distance of particles</param>
  /// <param name="share">above 0 and below 1: fraction of the mass there that moves from the
  /// particles to the body</param>
  public BodyId AddHandle(double u, double v, double reach, double share) {
    BodyId body;
    NativeError error;
    Native.Check(Native.tandem_cloth_add_handle(handle, u, v, reach, share, &body, &error),
                 ref error);
    return body;
  }
}

/// <summary>An unconscious person: eleven bodies on ten joints with human limits.</summary>
public sealed unsafe class Ragdoll : Part {
  private readonly RagdollHandle handle = new RagdollHandle();

  public Ragdoll(World world, RagdollDef def) : base(world) {
    NativeError error;
    Adopt(handle, Native.tandem_ragdoll_create(world.Handle, &def, &error), ref error);
  }

  /// <summary>Pelvis, chest, head, left upper arm and forearm, right upper arm and forearm, left
  /// thigh and shin, right thigh and shin, like Car.Bodies.</summary>
  public int Bodies(BodyId[] into) {
    fixed (BodyId* bodies = into) {
      return (int)Native.tandem_ragdoll_bodies(handle, bodies, Capacity(into));
    }
  }
}

}  // namespace Tandem
