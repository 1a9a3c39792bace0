// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Runtime.InteropServices;
using System.Text;

// Names and order are those of tandem/c/tandem.h; the tests compare the layouts with it.
namespace Tandem {

/// <summary>IL2CPP finds it by this name, wherever it is declared.</summary>
[AttributeUsage(AttributeTargets.Method)]
internal sealed class MonoPInvokeCallbackAttribute : Attribute {
  public MonoPInvokeCallbackAttribute(Type type) {}
}

[StructLayout(LayoutKind.Sequential)]
internal unsafe struct NativeError {
  public Result Result;
  public fixed byte Text[256];

  public TandemException Thrown() {
    fixed (byte* text = Text) {
      var length = 0;
      while (length < 256 && text[length] != 0) ++length;
      return new TandemException(Result, Encoding.UTF8.GetString(text, length));
    }
  }
}

[StructLayout(LayoutKind.Sequential)]
internal unsafe struct NativeShape {
  public ShapeKind Kind;
  public double Radius, HalfHeight;
  public Vec3 HalfExtents;
  public Vec3 Normal;
  public double Offset;
  public Vec3* Points;
  public UIntPtr PointCount;
  public uint* Triangles;
  public UIntPtr TriangleCount;
  public uint Columns, Rows;
  public double SpacingX, SpacingY;
  public double* Heights;
}

[StructLayout(LayoutKind.Sequential)]
internal struct NativeColliderDef {
  public BodyId Body;
  public NativeShape Shape;
  public Pose Local;
  public double Friction;
  public double Restitution;
  public uint Category, Mask;
  public int Group;
  public int Sensor;
}

[StructLayout(LayoutKind.Sequential)]
internal struct NativeQueryFilter {
  public uint Category, Mask;
  public int Group;
  public BodyId Ignore;
  public int Sensors;
  public int BackFaces;
  public IntPtr Accept;
  public IntPtr User;
}

[UnmanagedFunctionPointer(CallingConvention.Cdecl)]
internal delegate int AcceptFunction(IntPtr user, ColliderId collider);

/// <summary>Worlds, bodies, shapes, joints, events, queries.</summary>
internal static unsafe partial class Native {
  /// <summary>The C interface and its dependencies in one file.</summary>
  internal const string Library = "tandem_csharp";
  private const CallingConvention C = CallingConvention.Cdecl;

  /// <summary>With another version defaults would be misplaced, or memory overwritten.</summary>
  internal static void CheckVersion() {
    const uint version = 2;  // of the header that the structs follow
    if (tandem_c_version() == version) return;
    throw new TandemException(
        Result.Failed,
        $"the library's TANDEM_C_VERSION must be {version} and is {tandem_c_version()}");
  }

  internal static void Check(Result result, ref NativeError error) {
    if (result != Result.Ok) throw error.Thrown();
  }

  /// <summary>UTF-8, zero-terminated.</summary>
  internal static byte[] Text(string text) {
    if (text == null) throw new ArgumentNullException(nameof(text));
    if (text.IndexOf('\0') >= 0) {
      throw new TandemException(Result.InvalidArgument, $"text '{text}' must hold no character 0");
    }
    return Encoding.UTF8.GetBytes(text + "\0");
  }

  internal static void CheckCount(string field, int count, Array array) {
    if (count < 0 || count > (array == null ? 0 : array.Length)) {
      throw new TandemException(
          Result.InvalidArgument,
          $"{field} must be 0 to {(array == null ? 0 : array.Length)}, the array's length, " +
              $"and is {count}");
    }
  }

  [DllImport(Library, CallingConvention = C)]
  internal static extern uint tandem_c_version();

  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_world_def_init(out WorldDef def);
  [DllImport(Library, CallingConvention = C)]
  internal static extern IntPtr tandem_world_create(WorldDef* def, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_world_destroy(IntPtr world);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_world_step(WorldHandle world, double dt, StepReport* report,
                                                  NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_world_set_gravity(WorldHandle world, Vec3 gravity,
                                                         NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern ulong tandem_world_hash(WorldHandle world);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_world_snapshot(WorldHandle world, byte* buffer,
                                                      UIntPtr* size, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_world_restore(WorldHandle world, byte* bytes, UIntPtr size,
                                                     NativeError* error);

  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_body_def_init(out BodyDef def);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_body_add(WorldHandle world, BodyDef* def, BodyId* body,
                                                NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_body_remove(WorldHandle world, BodyId body,
                                                   NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern int tandem_body_exists(WorldHandle world, BodyId body);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_body_state(WorldHandle world, BodyId body, BodyState* state,
                                                  NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_body_states(WorldHandle world, BodyId* bodies,
                                                   UIntPtr count, BodyState* states,
                                                   NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern int tandem_body_awake(WorldHandle world, BodyId body);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_body_set_pose(WorldHandle world, BodyId body, Pose* pose,
                                                     NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_body_set_twist(WorldHandle world, BodyId body, Twist* twist,
                                                      NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_body_move_to(WorldHandle world, BodyId body, Pose* pose,
                                                    NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_body_apply_force(WorldHandle world, BodyId body, Vec3 force,
                                                        Vec3* point, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_body_apply_torque(WorldHandle world, BodyId body,
                                                         Vec3 torque, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_body_apply_impulse(WorldHandle world, BodyId body,
                                                          Vec3 impulse, Vec3* point,
                                                          NativeError* error);

  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_shape_init(out NativeShape shape, ShapeKind kind);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_shape_mass(NativeShape* shape, double density,
                                                  MassProperties* mass, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_collider_def_init(out NativeColliderDef def, ShapeKind kind);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_collider_add(WorldHandle world, NativeColliderDef* def,
                                                    ColliderId* collider, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_collider_remove(WorldHandle world, ColliderId collider,
                                                       NativeError* error);

  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_joint_def_init(out JointDef def, JointKind kind);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_joint_add(WorldHandle world, JointDef* def, JointId* joint,
                                                 NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_joint_remove(WorldHandle world, JointId joint,
                                                    NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_joint_set_motor(WorldHandle world, JointId joint,
                                                       MotorMode mode, double target,
                                                       double max_force, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_joint_set_servo(WorldHandle world, JointId joint,
                                                       MotorMode mode, double target,
                                                       double stiffness, double damping,
                                                       double max_force, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_joint_position(WorldHandle world, JointId joint,
                                                      double* position, int* broken,
                                                      NativeError* error);

  [DllImport(Library, CallingConvention = C)]
  internal static extern UIntPtr tandem_world_contacts(WorldHandle world, ContactList list,
                                                       Contact* contacts, UIntPtr capacity);
  [DllImport(Library, CallingConvention = C)]
  internal static extern UIntPtr tandem_world_hits(WorldHandle world, Hit* hits, UIntPtr capacity);

  [DllImport(Library, CallingConvention = C)]
  internal static extern IntPtr tandem_query_create(WorldHandle world, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_query_destroy(IntPtr query);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_query_update(QueryHandle query, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_query_filter_init(out NativeQueryFilter filter);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_query_ray(QueryHandle query, Vec3 origin, Vec3 direction,
                                                 double max_distance, NativeQueryFilter* filter,
                                                 QueryHit* hits, UIntPtr capacity, UIntPtr* count,
                                                 NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_query_cast(QueryHandle query, NativeShape* shape,
                                                  Pose* start, Vec3 displacement,
                                                  NativeQueryFilter* filter, QueryHit* hits,
                                                  UIntPtr capacity, UIntPtr* count,
                                                  NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_query_closest(QueryHandle query, NativeShape* shape,
                                                     Pose* pose, double max_distance,
                                                     NativeQueryFilter* filter, QueryHit* hits,
                                                     UIntPtr capacity, UIntPtr* count,
                                                     NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_query_overlap(QueryHandle query, NativeShape* shape,
                                                     Pose* pose, NativeQueryFilter* filter,
                                                     ColliderId* colliders, UIntPtr capacity,
                                                     UIntPtr* count, NativeError* error);
}

}  // namespace Tandem
