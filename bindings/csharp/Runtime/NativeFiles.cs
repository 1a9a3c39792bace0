// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Runtime.InteropServices;

namespace Tandem {

[StructLayout(LayoutKind.Sequential)]
internal unsafe struct NativeNamedBody {
  public byte* Name;
  public BodyId Body;
}

[StructLayout(LayoutKind.Sequential)]
internal unsafe struct NativeNamedJoint {
  public byte* Name;
  public JointId Joint;
}

internal sealed class SceneFileHandle : NativeHandle {
  protected override void Free() => Native.tandem_scene_file_destroy(handle);
}

/// <summary>Scenes from files.</summary>
internal static unsafe partial class Native {
  [DllImport(Library, CallingConvention = C)]
  internal static extern IntPtr tandem_scene_load(byte[] path, WorldDef* def, IntPtr* file,
                                                  NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern IntPtr tandem_scene_parse(SceneFormat format, byte* text, UIntPtr size,
                                                   byte[] folder, WorldDef* def, IntPtr* file,
                                                   NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_scene_file_destroy(IntPtr file);
  [DllImport(Library, CallingConvention = C)]
  internal static extern UIntPtr tandem_scene_file_bodies(SceneFileHandle file,
                                                          NativeNamedBody* bodies,
                                                          UIntPtr capacity);
  [DllImport(Library, CallingConvention = C)]
  internal static extern UIntPtr tandem_scene_file_joints(SceneFileHandle file,
                                                          NativeNamedJoint* joints,
                                                          UIntPtr capacity);
  [DllImport(Library, CallingConvention = C)]
  internal static extern UIntPtr tandem_scene_file_warnings(SceneFileHandle file, byte** warnings,
                                                            UIntPtr capacity);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_scene_file_find_body(SceneFileHandle file, byte[] name,
                                                            BodyId* body, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_scene_file_find_joint(SceneFileHandle file, byte[] name,
                                                             JointId* joint, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_scene_file_pose(SceneFileHandle file, byte[] name,
                                                       Pose* pose, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_scene_add_body(WorldHandle world, byte* text, UIntPtr size,
                                                      BodyId* body, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_scene_write(WorldHandle world, IntPtr file, byte* buffer,
                                                   UIntPtr* size, NativeError* error);
}

}  // namespace Tandem
