// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Text;

namespace Tandem {

public enum SceneFormat {
  Json = 0,  // Tandem's own, docs/scene_files.md
  Gltf = 1   // glTF 2.0 with physics, or .glb; its y is up, the world's z is
}

public struct NamedBody {
  public string Name;  // may be empty
  public BodyId Body;
}

public struct NamedJoint {
  public string Name;  // may be empty
  public JointId Joint;
}

/// <summary>A world made from a file, and the file's names and other data. Files are untrusted; an
/// error names file, place in it, rule and value.</summary>
public sealed unsafe class SceneFile : IDisposable {
  private readonly SceneFileHandle handle = new SceneFileHandle();

  /// <summary>Dispose of it separately, before or after the file.</summary>
  public World World { get; }

  private SceneFile(IntPtr world, IntPtr file, ref NativeError error) {
    World = new World(world, ref error);
    handle.Adopt(file, ref error, World.Handle);
    World.Dependents.Add(this);
  }

  /// <summary>Names that end in .gltf or .glb are glTF.</summary>
  /// <param name="def">null: WorldDef.Default. Its gravity counts if the file has none.</param>
  public static SceneFile Load(string path, WorldDef? def = null) {
    Native.CheckVersion();
    var worldDef = def ?? WorldDef.Default;
    IntPtr file;
    NativeError error;
    var world = Native.tandem_scene_load(Native.Text(path), &worldDef, &file, &error);
    return new SceneFile(world, file, ref error);
  }

  /// <summary>The same from text in memory.</summary>
  /// <param name="folder">for glTF, whose buffers may be files</param>
  public static SceneFile Parse(SceneFormat format, byte[] text, string folder = "",
                                WorldDef? def = null) {
    if (text == null) throw new ArgumentNullException(nameof(text));
    Native.CheckVersion();
    var worldDef = def ?? WorldDef.Default;
    IntPtr file;
    NativeError error;
    fixed (byte* from = text) {
      var world = Native.tandem_scene_parse(format, from, (UIntPtr)text.Length,
                                            Native.Text(folder), &worldDef, &file, &error);
      return new SceneFile(world, file, ref error);
    }
  }

  /// <summary>The world remains.</summary>
  public void Dispose() {
    handle.Dispose();
    World.Dependents.Remove(this);
  }

  /// <summary>In the file's order.</summary>
  public NamedBody[] Bodies() {
    var bodies = new NativeNamedBody[(int)Native.tandem_scene_file_bodies(handle, null,
                                                                          UIntPtr.Zero)];
    var named = new NamedBody[bodies.Length];
    fixed (NativeNamedBody* all = bodies) {
      Native.tandem_scene_file_bodies(handle, all, (UIntPtr)bodies.Length);
    }
    for (var i = 0; i < named.Length; ++i) {
      named[i] = new NamedBody {Name = Text(bodies[i].Name), Body = bodies[i].Body};
    }
    return named;
  }

  public NamedJoint[] Joints() {
    var joints = new NativeNamedJoint[(int)Native.tandem_scene_file_joints(handle, null,
                                                                           UIntPtr.Zero)];
    var named = new NamedJoint[joints.Length];
    fixed (NativeNamedJoint* all = joints) {
      Native.tandem_scene_file_joints(handle, all, (UIntPtr)joints.Length);
    }
    for (var i = 0; i < named.Length; ++i) {
      named[i] = new NamedJoint {Name = Text(joints[i].Name), Joint = joints[i].Joint};
    }
    return named;
  }

  /// <summary>Parts of the file that the world lacks, with their places.</summary>
  public string[] Warnings() {
    var texts = new IntPtr[(int)Native.tandem_scene_file_warnings(handle, null, UIntPtr.Zero)];
    fixed (IntPtr* all = texts) {
      Native.tandem_scene_file_warnings(handle, (byte**)all, (UIntPtr)texts.Length);
    }
    return Array.ConvertAll(texts, text => Text((byte*)text));
  }

  /// <summary>The first one of that name.</summary>
  public BodyId Body(string name) {
    BodyId body;
    NativeError error;
    Native.Check(Native.tandem_scene_file_find_body(handle, Native.Text(name), &body, &error),
                 ref error);
    return body;
  }

  public JointId Joint(string name) {
    JointId joint;
    NativeError error;
    Native.Check(Native.tandem_scene_file_find_joint(handle, Native.Text(name), &joint, &error),
                 ref error);
    return joint;
  }

  /// <summary>Present pose, world, of the frame of that name: for a body the frame of its shape,
  /// while World.State has the centre of mass.</summary>
  public Pose Pose(string name) {
    Pose pose;
    NativeError error;
    Native.Check(Native.tandem_scene_file_pose(handle, Native.Text(name), &pose, &error),
                 ref error);
    return pose;
  }

  /// <summary>Add a body, from an element of "bodies" in Tandem's format.</summary>
  public static BodyId AddBody(World world, string text) {
    if (world == null) throw new ArgumentNullException(nameof(world));
    var bytes = Encoding.UTF8.GetBytes(text);
    BodyId body;
    NativeError error;
    fixed (byte* from = bytes) {
      Native.Check(Native.tandem_scene_add_body(world.Handle, from, (UIntPtr)bytes.Length, &body,
                                                &error),
                   ref error);
    }
    return body;
  }

  /// <summary>The world as text in Tandem's format, with the file's names.</summary>
  public string Write() => Write(World, handle);

  /// <summary>Without names.</summary>
  public static string Write(World world) => Write(world, null);

  private static string Write(World world, SceneFileHandle file) {
    if (world == null) throw new ArgumentNullException(nameof(world));
    var held = false;
    try {
      file?.DangerousAddRef(ref held);
      var names = file == null ? IntPtr.Zero : file.DangerousGetHandle();
      var size = UIntPtr.Zero;
      NativeError error;
      var result = Native.tandem_scene_write(world.Handle, names, null, &size, &error);
      if (result != Result.TooSmall) Native.Check(result, ref error);
      var buffer = new byte[(int)size];
      fixed (byte* into = buffer) {
        Native.Check(Native.tandem_scene_write(world.Handle, names, into, &size, &error),
                     ref error);
      }
      return Encoding.UTF8.GetString(buffer, 0, (int)size - 1);  // without its 0
    } finally {
      if (held) file.DangerousRelease();
    }
  }

  private static string Text(byte* text) {
    var length = 0;
    while (text[length] != 0) ++length;
    return Messages.Text(text, length);
  }
}

}  // namespace Tandem
