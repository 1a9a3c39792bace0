// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Runtime.InteropServices;

namespace Tandem {

internal sealed class CharacterHandle : NativeHandle {
  protected override void Free() => Native.tandem_character_destroy(handle);
}

internal sealed class CarHandle : NativeHandle {
  protected override void Free() => Native.tandem_car_destroy(handle);
}

internal sealed class RopeHandle : NativeHandle {
  protected override void Free() => Native.tandem_rope_destroy(handle);
}

internal sealed class ClothHandle : NativeHandle {
  protected override void Free() => Native.tandem_cloth_destroy(handle);
}

internal sealed class RagdollHandle : NativeHandle {
  protected override void Free() => Native.tandem_ragdoll_destroy(handle);
}

/// <summary>Characters, cars, ropes, cloth, ragdolls.</summary>
internal static unsafe partial class Native {
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_character_def_init(out CharacterDef def);
  [DllImport(Library, CallingConvention = C)]
  internal static extern IntPtr tandem_character_create(WorldHandle world, CharacterDef* def,
                                                        NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_character_destroy(IntPtr character);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_character_walk(CharacterHandle character, Vec3 velocity,
                                                      double dt, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_character_jump(CharacterHandle character, double speed,
                                                      NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_character_get_state(CharacterHandle character,
                                                           CharacterState* state,
                                                           NativeError* error);

  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_car_def_init(out CarDef def);
  [DllImport(Library, CallingConvention = C)]
  internal static extern IntPtr tandem_car_create(WorldHandle world, CarDef* def,
                                                  NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_car_destroy(IntPtr car);
  [DllImport(Library, CallingConvention = C)]
  internal static extern UIntPtr tandem_car_bodies(CarHandle car, BodyId* bodies, UIntPtr capacity);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_car_drive(CarHandle car, double throttle, double steer,
                                                 double brake, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern double tandem_car_speed(CarHandle car);

  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_rope_def_init(out RopeDef def);
  [DllImport(Library, CallingConvention = C)]
  internal static extern IntPtr tandem_rope_create(WorldHandle world, RopeDef* def,
                                                   NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_rope_destroy(IntPtr rope);
  [DllImport(Library, CallingConvention = C)]
  internal static extern UIntPtr tandem_rope_bodies(RopeHandle rope, BodyId* bodies,
                                                    UIntPtr capacity);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_rope_attach(RopeHandle rope, uint particle, BodyId host,
                                                   Attachment* attachment, NativeError* error);

  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_cloth_def_init(out ClothDef def);
  [DllImport(Library, CallingConvention = C)]
  internal static extern IntPtr tandem_cloth_create(WorldHandle world, ClothDef* def,
                                                    NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_cloth_destroy(IntPtr cloth);
  [DllImport(Library, CallingConvention = C)]
  internal static extern UIntPtr tandem_cloth_bodies(ClothHandle cloth, BodyId* bodies,
                                                     UIntPtr capacity);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_cloth_attach(ClothHandle cloth, int column, int row,
                                                    BodyId host, Attachment* attachment,
                                                    NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_cloth_tether(ClothHandle cloth, NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_cloth_add_handle(ClothHandle cloth, double u, double v,
                                                        double reach, double share, BodyId* body,
                                                        NativeError* error);

  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_ragdoll_def_init(out RagdollDef def);
  [DllImport(Library, CallingConvention = C)]
  internal static extern IntPtr tandem_ragdoll_create(WorldHandle world, RagdollDef* def,
                                                      NativeError* error);
  [DllImport(Library, CallingConvention = C)]
  internal static extern void tandem_ragdoll_destroy(IntPtr ragdoll);
  [DllImport(Library, CallingConvention = C)]
  internal static extern UIntPtr tandem_ragdoll_bodies(RagdollHandle ragdoll, BodyId* bodies,
                                                       UIntPtr capacity);

  [DllImport(Library, CallingConvention = C)]
  internal static extern Result tandem_attachment_remove(WorldHandle world, Attachment attachment,
                                                         NativeError* error);
}

}  // namespace Tandem
