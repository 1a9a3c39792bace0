// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;

namespace Tandem {

public enum ShapeKind {
  Sphere = 0,
  Box = 1,
  Capsule = 2,
  Cylinder = 3,
  Cone = 4,
  HalfSpace = 5,
  Hull = 6,
  Mesh = 7,
  Heights = 8
}

/// <summary>Immutable and reusable. Arrays are kept, not copied: do not change them.</summary>
public sealed unsafe class Shape {
  public ShapeKind Kind => native.Kind;

  internal readonly Vec3[] Points;
  internal readonly uint[] Triangles;
  internal readonly double[] HeightSamples;
  private NativeShape native;

  private Shape(ShapeKind kind, Vec3[] points = null, uint[] triangles = null,
                double[] heights = null) {
    Native.tandem_shape_init(out native, kind);
    Points = points;
    Triangles = triangles;
    HeightSamples = heights;
    native.PointCount = (UIntPtr)(points == null ? 0 : points.Length);
    native.TriangleCount = (UIntPtr)(triangles == null ? 0 : triangles.Length / 3);
  }

  /// <summary>The struct for the library, valid while the arrays are pinned.</summary>
  internal NativeShape At(Vec3* points, uint* triangles, double* heights) {
    var shape = native;
    shape.Points = points;
    shape.Triangles = triangles;
    shape.Heights = heights;
    return shape;
  }

  public static Shape Sphere(double radius) {
    var shape = new Shape(ShapeKind.Sphere);
    shape.native.Radius = radius;
    return shape;
  }

  /// <param name="halfExtents">m, half its edges</param>
  public static Shape Box(Vec3 halfExtents) {
    var shape = new Shape(ShapeKind.Box);
    shape.native.HalfExtents = halfExtents;
    return shape;
  }

  public static Shape Box(double x, double y, double z) => Box(new Vec3(x, y, z));

  /// <summary>Along z.</summary>
  /// <param name="halfHeight">m, without the caps</param>
  public static Shape Capsule(double radius, double halfHeight) =>
      Round(ShapeKind.Capsule, radius, halfHeight);

  /// <summary>Along z.</summary>
  public static Shape Cylinder(double radius, double halfHeight) =>
      Round(ShapeKind.Cylinder, radius, halfHeight);

  /// <summary>Its apex is up z.</summary>
  public static Shape Cone(double radius, double halfHeight) =>
      Round(ShapeKind.Cone, radius, halfHeight);

  private static Shape Round(ShapeKind kind, double radius, double halfHeight) {
    var shape = new Shape(kind);
    shape.native.Radius = radius;
    shape.native.HalfHeight = halfHeight;
    return shape;
  }

  /// <summary>Solid where normal . x &lt;= offset.</summary>
  public static Shape HalfSpace(Vec3 normal, double offset = 0.0) {
    var shape = new Shape(ShapeKind.HalfSpace);
    shape.native.Normal = normal;
    shape.native.Offset = offset;
    return shape;
  }

  /// <summary>All below z = 0.</summary>
  public static Shape Ground() => HalfSpace(new Vec3(0.0, 0.0, 1.0));

  /// <summary>The convex hull of the points.</summary>
  public static Shape Hull(Vec3[] points) => new Shape(ShapeKind.Hull, points);

  /// <summary>For bodies that do not move.</summary>
  /// <param name="triangles">three indices each, counter-clockwise seen from outside</param>
  public static Shape Mesh(Vec3[] points, uint[] triangles) {
    if (triangles != null && triangles.Length % 3 != 0) {
      throw new TandemException(Result.InvalidArgument,
                                $"triangles must hold three indices each, not {triangles.Length}");
    }
    return new Shape(ShapeKind.Mesh, points, triangles);
  }

  /// <summary>For bodies that do not move.</summary>
  /// <param name="heights">m, row by row</param>
  public static Shape Heights(int columns, int rows, double spacingX, double spacingY,
                              double[] heights) {
    if (heights == null || columns < 0 || rows < 0 || heights.Length != (long)columns * rows) {
      throw new TandemException(
          Result.InvalidArgument,
          $"heights must be {columns} x {rows}, not {(heights == null ? 0 : heights.Length)}");
    }
    var shape = new Shape(ShapeKind.Heights, null, null, heights);
    shape.native.Columns = (uint)columns;
    shape.native.Rows = (uint)rows;
    shape.native.SpacingX = spacingX;
    shape.native.SpacingY = spacingY;
    return shape;
  }

  /// <param name="density">kg/m^3, > 0</param>
  public MassProperties Mass(double density) {
    fixed (Vec3* points = Points)
    fixed (uint* triangles = Triangles)
    fixed (double* heights = HeightSamples) {
      var shape = At(points, triangles, heights);
      MassProperties mass;
      NativeError error;
      Native.Check(Native.tandem_shape_mass(&shape, density, &mass, &error), ref error);
      return mass;
    }
  }
}

/// <summary>A shape on a body. Take ColliderDef.Of and change it.</summary>
public struct ColliderDef {
  public BodyId Body;
  public Shape Shape;
  public Pose Local;           // of the shape in the body's frame
  public double Friction;      // 0.5
  public double Restitution;   // 0 to 1; 0
  public uint Category, Mask;  // two collide if each one's category is in the other's mask; 1, all
  public int Group;            // equal and > 0: always collide, equal and < 0: never; 0
  public bool Sensor;          // makes no contacts, only events; false

  public static ColliderDef Of(BodyId body, Shape shape) {
    if (shape == null) throw new ArgumentNullException(nameof(shape));
    Native.tandem_collider_def_init(out var def, shape.Kind);
    return new ColliderDef {Body = body,
                            Shape = shape,
                            Local = def.Local,
                            Friction = def.Friction,
                            Restitution = def.Restitution,
                            Category = def.Category,
                            Mask = def.Mask,
                            Group = def.Group,
                            Sensor = def.Sensor != 0};
  }
}

}  // namespace Tandem
