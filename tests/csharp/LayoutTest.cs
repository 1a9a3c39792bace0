// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using System.Runtime.InteropServices;
using Tandem;

/// <summary>Every struct, enum and function of the header is here, laid out as there.</summary>
internal static class LayoutTest {
  private static readonly Dictionary<string, Type> named = new Dictionary<string, Type> {
      {"tandem_error", typeof(NativeError)},
      {"tandem_body", typeof(BodyId)},
      {"tandem_collider", typeof(ColliderId)},
      {"tandem_joint", typeof(JointId)},
      {"tandem_state", typeof(BodyState)},
      {"tandem_shape", typeof(NativeShape)},
      {"tandem_mass", typeof(MassProperties)},
      {"tandem_collider_def", typeof(NativeColliderDef)},
      {"tandem_query_filter", typeof(NativeQueryFilter)},
      {"tandem_transport_def", typeof(NativeTransportDef)},
      {"tandem_event", typeof(NativeEvent)},
      {"tandem_session_def", typeof(NativeSessionDef)},
      {"tandem_key", typeof(NativeKey)},
      {"tandem_trusted", typeof(NativeTrusted)},
      {"tandem_credentials", typeof(NativeCredentials)},
      {"tandem_tcp_def", typeof(NativeTcpDef)},
      {"tandem_udp_def", typeof(NativeUdpDef)},
      {"tandem_member", typeof(NativeMember)},
      {"tandem_filter", typeof(CollisionFilter)},
      {"tandem_named_body", typeof(NativeNamedBody)},
      {"tandem_named_joint", typeof(NativeNamedJoint)}};

  internal static void Run(string[] reference) {
    var words = reference.Select(line => line.Split(' ')).ToArray();
    foreach (var line in words.Where(w => w[0] == "struct")) Struct(line, words);
    foreach (var line in words.Where(w => w[0] == "enum")) Enum(line);
    Functions(words);
  }

  /// <summary>half_extents, HalfExtents and halfExtents are one name.</summary>
  private static string Plain(string name) => name.Replace("_", "").ToLowerInvariant();

  private static Type TypeOf(string name) {
    if (named.TryGetValue(name, out var type)) return type;
    var plain = Plain(name.Substring("tandem_".Length));
    return typeof(World).Assembly.GetTypes().FirstOrDefault(
        t => t.Namespace == "Tandem" && t.IsValueType && Plain(t.Name) == plain);
  }

  private static void Struct(string[] line, string[][] words) {
    var type = TypeOf(line[1]);
    Check.That(type != null, $"there is a struct for {line[1]}");
    if (type == null) return;
    Check.That(Marshal.SizeOf(type) == int.Parse(line[2]),
               $"{type.Name} has {line[2]} bytes, not {Marshal.SizeOf(type)}");
    // Types that are passed without a copy are those that can be pinned.
    GCHandle.Alloc(Array.CreateInstance(type, 1), GCHandleType.Pinned).Free();
    var fields = type.GetFields(BindingFlags.Instance | BindingFlags.Public |
                                BindingFlags.NonPublic);
    var declared = words.Where(w => w[0] == "field" && w[1] == line[1]).ToArray();
    Check.That(fields.Length == declared.Length,
               $"{type.Name} has {declared.Length} fields, not {fields.Length}");
    foreach (var field in declared) {
      var here = fields.FirstOrDefault(f => Plain(f.Name) == Plain(field[2]));
      Check.That(here != null, $"{type.Name} has {field[2]}");
      if (here == null) continue;
      var offset = Marshal.OffsetOf(type, here.Name).ToInt64();
      Check.That(offset == long.Parse(field[3]),
                 $"{type.Name}.{here.Name} is at {field[3]}, not {offset}");
      Check.That(SizeOf(here.FieldType) == int.Parse(field[4]),
                 $"{type.Name}.{here.Name} has {field[4]} bytes, not {SizeOf(here.FieldType)}");
    }
  }

  private static int SizeOf(Type type) {
    if (type.IsEnum) return Marshal.SizeOf(type.GetEnumUnderlyingType());
    return type.IsPointer ? IntPtr.Size : Marshal.SizeOf(type);
  }

  private static readonly Dictionary<string, Type> enums = new Dictionary<string, Type> {
      {"tandem_result", typeof(Result)},
      {"tandem_body_type", typeof(BodyType)},
      {"tandem_shape_kind", typeof(ShapeKind)},
      {"tandem_joint_kind", typeof(JointKind)},
      {"tandem_motor_mode", typeof(MotorMode)},
      {"tandem_contact_list", typeof(ContactList)},
      {"tandem_delivery", typeof(Delivery)},
      {"tandem_clock_source", typeof(ClockSource)},
      {"tandem_step_status", typeof(StepStatus)},
      {"tandem_footing", typeof(Footing)},
      {"tandem_scene_format", typeof(SceneFormat)}};

  private static void Enum(string[] line) {
    Check.That(enums.TryGetValue(line[1], out var type), $"there is an enum for {line[1]}");
    if (type == null) return;
    var here = System.Enum.GetName(type, int.Parse(line[3]));
    Check.That(here != null && Plain(line[2]).EndsWith(Plain(here)),
               $"{type.Name} has {line[2]} = {line[3]}");
  }

  private static void Functions(string[][] words) {
    var declared = words.Where(w => w[0] == "function").ToDictionary(w => w[1], w => int.Parse(w[2]));
    var here = typeof(Native)
                   .GetMethods(BindingFlags.Static | BindingFlags.NonPublic)
                   .Where(m => m.Name.StartsWith("tandem_"))
                   .ToDictionary(m => m.Name);
    foreach (var name in declared.Keys.Except(here.Keys)) Check.That(false, $"{name} is declared");
    foreach (var name in here.Keys.Except(declared.Keys)) {
      Check.That(false, $"{name} is in the header");
    }
    foreach (var method in here.Values.Where(m => declared.ContainsKey(m.Name))) {
      Check.That(method.GetParameters().Length == declared[method.Name],
                 $"{method.Name} has {declared[method.Name]} parameters");
      Marshal.Prelink(method);  // or throws that the library has it not
    }
    Check.That(declared.Count > 80, $"{declared.Count} functions are the header's");
  }
}
