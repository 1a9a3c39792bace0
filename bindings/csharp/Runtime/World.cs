// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Collections.Generic;

namespace Tandem {

/// <summary>Bodies, shapes, joints, and the solver that steps them. A world and its peers may be
/// used by one thread at a time.</summary>
public sealed unsafe partial class World : IDisposable {
  internal readonly WorldHandle Handle = new WorldHandle();
  /// <summary>Its queries, peers, characters and so on: the collector, which has its own thread,
  /// frees none of them while the world is in use.</summary>
  internal readonly List<object> Dependents = new List<object>();

  public World() : this(WorldDef.Default) {}

  public World(WorldDef def) {
    Native.CheckVersion();
    NativeError error;
    Handle.Adopt(Native.tandem_world_create(&def, &error), ref error);
  }

  /// <summary>A world made elsewhere.</summary>
  internal World(IntPtr made, ref NativeError error) {
    Handle.Adopt(made, ref error);
  }

  /// <summary>It is freed after everything that belongs to it.</summary>
  public void Dispose() => Handle.Dispose();

  /// <param name="dt">s, 1e-5 to 1e6</param>
  public StepReport Step(double dt) {
    StepReport report;
    NativeError error;
    Native.Check(Native.tandem_world_step(Handle, dt, &report, &error), ref error);
    return report;
  }

  public void SetGravity(Vec3 gravity) {
    NativeError error;
    Native.Check(Native.tandem_world_set_gravity(Handle, gravity, &error), ref error);
  }

  /// <summary>Equal for bitwise equal worlds.</summary>
  public ulong Hash => Native.tandem_world_hash(Handle);

  /// <summary>Everything that the next step and its events depend on.</summary>
  public byte[] Snapshot() {
    byte[] bytes = null;
    var size = Snapshot(ref bytes);
    Array.Resize(ref bytes, size);
    return bytes;
  }

  /// <summary>Into a buffer, which is replaced if it is too small.</summary>
  /// <returns>bytes of the snapshot</returns>
  public int Snapshot(ref byte[] buffer) {
    while (true) {
      var size = (UIntPtr)(buffer == null ? 0 : buffer.Length);
      NativeError error;
      fixed (byte* into = buffer) {
        var result = Native.tandem_world_snapshot(Handle, into, &size, &error);
        if (result != Result.TooSmall) {
          Native.Check(result, ref error);
          return (int)size;
        }
      }
      buffer = new byte[(int)size];
    }
  }

  /// <summary>Restores a snapshot of a world that was built the same way. The input is
  /// untrusted.</summary>
  public void Restore(byte[] bytes) => Restore(bytes, bytes == null ? 0 : bytes.Length);

  public void Restore(byte[] bytes, int size) {
    Native.CheckCount(nameof(size), size, bytes);
    NativeError error;
    fixed (byte* from = bytes) {
      Native.Check(Native.tandem_world_restore(Handle, from, (UIntPtr)size, &error), ref error);
    }
  }

  public ColliderId AddCollider(ColliderDef def) {
    if (def.Shape == null) throw new ArgumentNullException(nameof(def), "Shape must be set");
    fixed (Vec3* points = def.Shape.Points)
    fixed (uint* triangles = def.Shape.Triangles)
    fixed (double* heights = def.Shape.HeightSamples) {
      var native = new NativeColliderDef {Body = def.Body,
                                          Shape = def.Shape.At(points, triangles, heights),
                                          Local = def.Local,
                                          Friction = def.Friction,
                                          Restitution = def.Restitution,
                                          Category = def.Category,
                                          Mask = def.Mask,
                                          Group = def.Group,
                                          Sensor = def.Sensor ? 1 : 0};
      ColliderId collider;
      NativeError error;
      Native.Check(Native.tandem_collider_add(Handle, &native, &collider, &error), ref error);
      return collider;
    }
  }

  public ColliderId AddCollider(BodyId body, Shape shape) =>
      AddCollider(ColliderDef.Of(body, shape));

  public void RemoveCollider(ColliderId collider) {
    NativeError error;
    Native.Check(Native.tandem_collider_remove(Handle, collider, &error), ref error);
  }

  public JointId AddJoint(JointDef def) {
    JointId joint;
    NativeError error;
    Native.Check(Native.tandem_joint_add(Handle, &def, &joint, &error), ref error);
    return joint;
  }

  public void RemoveJoint(JointId joint) {
    NativeError error;
    Native.Check(Native.tandem_joint_remove(Handle, joint, &error), ref error);
  }

  /// <summary>For a hinge or a slider.</summary>
  public void SetMotor(JointId joint, MotorMode mode, double target, double maxForce) {
    NativeError error;
    Native.Check(Native.tandem_joint_set_motor(Handle, joint, mode, target, maxForce, &error),
                 ref error);
  }

  /// <summary>A motor with a spring and a damper. N/m and N s/m, or N m/rad and N m
  /// s/rad.</summary>
  public void SetServo(JointId joint, MotorMode mode, double target, double stiffness,
                       double damping, double maxForce) {
    NativeError error;
    Native.Check(Native.tandem_joint_set_servo(Handle, joint, mode, target, stiffness, damping,
                                               maxForce, &error),
                 ref error);
  }

  /// <summary>Releases a particle of a rope or a cloth, which still collides with
  /// nothing.</summary>
  public void RemoveAttachment(Attachment attachment) {
    NativeError error;
    Native.Check(Native.tandem_attachment_remove(Handle, attachment, &error), ref error);
  }

  /// <summary>rad or m of a hinge or a slider, 0 of others.</summary>
  public double JointPosition(JointId joint) {
    double position;
    NativeError error;
    Native.Check(Native.tandem_joint_position(Handle, joint, &position, null, &error), ref error);
    return position;
  }

  public bool JointBroken(JointId joint) {
    double position;
    int broken;
    NativeError error;
    Native.Check(Native.tandem_joint_position(Handle, joint, &position, &broken, &error),
                 ref error);
    return broken != 0;
  }

  /// <summary>Events of the last step, if the world collects them: fills the array as far as it
  /// goes; it may be null.</summary>
  /// <returns>the total number</returns>
  public int Contacts(ContactList list, Contact[] into) {
    fixed (Contact* contacts = into) {
      return (int)Native.tandem_world_contacts(Handle, list, contacts,
                                               (UIntPtr)(into == null ? 0 : into.Length));
    }
  }

  /// <summary>Hits of the last step, like Contacts.</summary>
  public int Hits(Hit[] into) {
    fixed (Hit* hits = into) {
      return (int)Native.tandem_world_hits(Handle, hits,
                                           (UIntPtr)(into == null ? 0 : into.Length));
    }
  }
}

}  // namespace Tandem
