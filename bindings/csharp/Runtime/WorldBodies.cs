// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;

namespace Tandem {

/// <summary>Bodies: states, forces and motions.</summary>
public sealed unsafe partial class World {
  public BodyId AddBody(BodyDef def) {
    BodyId body;
    NativeError error;
    Native.Check(Native.tandem_body_add(Handle, &def, &body, &error), ref error);
    return body;
  }

  /// <summary>A body of one shape, with the shape's mass. `pose` is that of the shape's frame; the
  /// body's is that of its centre of mass, which differs for cones, hulls and the like.</summary>
  /// <param name="density">kg/m^3; of dynamic bodies</param>
  public BodyId AddBody(BodyType type, Shape shape, Pose pose, double density = 1000.0) {
    if (shape == null) throw new ArgumentNullException(nameof(shape));
    var def = BodyDef.Default;
    var local = Pose.Identity;
    def.Type = type;
    def.Pose = pose;
    if (type == BodyType.Dynamic) {
      var mass = shape.Mass(density);
      def.Mass = mass.Mass;
      def.Inertia = mass.Inertia;
      def.Pose.Position += pose.Orientation * mass.CentreOfMass;
      local.Position = -mass.CentreOfMass;
    }
    var body = AddBody(def);
    var collider = ColliderDef.Of(body, shape);
    collider.Local = local;
    try {
      AddCollider(collider);
    } catch {
      RemoveBody(body);
      throw;
    }
    return body;
  }

  /// <summary>Also removes its colliders and joints.</summary>
  public void RemoveBody(BodyId body) {
    NativeError error;
    Native.Check(Native.tandem_body_remove(Handle, body, &error), ref error);
  }

  public bool Exists(BodyId body) => Native.tandem_body_exists(Handle, body) != 0;

  public bool Awake(BodyId body) => Native.tandem_body_awake(Handle, body) != 0;

  public BodyState State(BodyId body) {
    BodyState state;
    NativeError error;
    Native.Check(Native.tandem_body_state(Handle, body, &state, &error), ref error);
    return state;
  }

  /// <summary>States of many bodies at once, which is cheapest.</summary>
  public void States(BodyId[] bodies, BodyState[] states) =>
      States(bodies, bodies == null ? 0 : bodies.Length, states);

  /// <summary>States of the first `count`.</summary>
  public void States(BodyId[] bodies, int count, BodyState[] states) {
    Native.CheckCount(nameof(count), count, bodies);
    Native.CheckCount(nameof(count), count, states);
    NativeError error;
    fixed (BodyId* from = bodies)
    fixed (BodyState* into = states) {
      Native.Check(Native.tandem_body_states(Handle, from, (UIntPtr)count, into, &error),
                   ref error);
    }
  }

  public void SetPose(BodyId body, Pose pose) {
    NativeError error;
    Native.Check(Native.tandem_body_set_pose(Handle, body, &pose, &error), ref error);
  }

  public void SetTwist(BodyId body, Twist twist) {
    NativeError error;
    Native.Check(Native.tandem_body_set_twist(Handle, body, &twist, &error), ref error);
  }

  /// <summary>The kinematic body arrives there in the next step.</summary>
  public void MoveTo(BodyId body, Pose pose) {
    NativeError error;
    Native.Check(Native.tandem_body_move_to(Handle, body, &pose, &error), ref error);
  }

  /// <summary>Acts during the next step, N.</summary>
  /// <param name="point">m, world; null: the centre of mass</param>
  public void ApplyForce(BodyId body, Vec3 force, Vec3? point = null) {
    var at = point.GetValueOrDefault();
    NativeError error;
    Native.Check(Native.tandem_body_apply_force(Handle, body, force, point.HasValue ? &at : null,
                                                &error),
                 ref error);
  }

  /// <summary>Acts during the next step, N m.</summary>
  public void ApplyTorque(BodyId body, Vec3 torque) {
    NativeError error;
    Native.Check(Native.tandem_body_apply_torque(Handle, body, torque, &error), ref error);
  }

  /// <summary>Acts at once, N s.</summary>
  /// <param name="point">m, world; null: the centre of mass</param>
  public void ApplyImpulse(BodyId body, Vec3 impulse, Vec3? point = null) {
    var at = point.GetValueOrDefault();
    NativeError error;
    Native.Check(Native.tandem_body_apply_impulse(Handle, body, impulse,
                                                  point.HasValue ? &at : null, &error),
                 ref error);
  }
}

}  // namespace Tandem
