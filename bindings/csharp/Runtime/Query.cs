// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Runtime.InteropServices;

namespace Tandem {

/// <summary>Which colliders a query sees. Take Default and change it.</summary>
public struct QueryFilter {
  public uint Category, Mask;  // as for a collider; all, all
  public int Group;            // as for a collider; 0
  public BodyId Ignore;        // skip all colliders of that body; BodyId.None
  public bool Sensors;         // include sensors; false
  public bool BackFaces;       // back faces of triangles stop rays and casts too; false
  /// <summary>Null: all. Called for candidates only, in any order.</summary>
  public Func<ColliderId, bool> Accept;

  public static QueryFilter Default {
    get {
      Native.tandem_query_filter_init(out var filter);
      return new QueryFilter {Category = filter.Category,
                              Mask = filter.Mask,
                              Group = filter.Group,
                              Ignore = filter.Ignore,
                              Sensors = filter.Sensors != 0,
                              BackFaces = filter.BackFaces != 0};
    }
  }
}

/// <summary>Rays, casts, overlaps and closest points among the colliders of a world, as of the last
/// Update. They fill the caller's arrays, which may be null, and return the total number; if there
/// is room for at most one, only whether there is any.</summary>
public sealed unsafe class Query : IDisposable {
  private static readonly AcceptFunction acceptFunction = AcceptCollider;
  private static readonly IntPtr acceptPointer =
      Marshal.GetFunctionPointerForDelegate(acceptFunction);

  private readonly QueryHandle handle = new QueryHandle();
  private readonly World world;
  private Func<ColliderId, bool> accept;
  private Exception failure;

  public Query(World world) {
    this.world = world ?? throw new ArgumentNullException(nameof(world));
    NativeError error;
    handle.Adopt(Native.tandem_query_create(world.Handle, &error), ref error, world.Handle);
    // Weak, as it must not keep itself alive.
    handle.User = GCHandle.Alloc(this, GCHandleType.Weak);
    world.Dependents.Add(this);
  }

  public void Dispose() {
    handle.Dispose();
    world.Dependents.Remove(this);
  }

  /// <summary>Update the query to the present bodies and colliders.</summary>
  public void Update() {
    NativeError error;
    Native.Check(Native.tandem_query_update(handle, &error), ref error);
  }

  /// <param name="direction">of any length above 0</param>
  /// <param name="maxDistance">m, > 0</param>
  public int Ray(Vec3 origin, Vec3 direction, double maxDistance, QueryHit[] into,
                 QueryFilter? filter = null) {
    var native = Begin(filter, out var outer);
    UIntPtr count;
    NativeError error;
    Result result;
    fixed (QueryHit* hits = into) {
      result = Native.tandem_query_ray(handle, origin, direction, maxDistance, &native, hits,
                                       Capacity(into), &count, &error);
    }
    return End(result, count, ref error, outer);
  }

  /// <summary>The nearest hit of a ray.</summary>
  public bool Ray(Vec3 origin, Vec3 direction, double maxDistance, out QueryHit hit,
                  QueryFilter? filter = null) {
    hit = default(QueryHit);
    var native = Begin(filter, out var outer);
    UIntPtr count;
    NativeError error;
    Result result;
    fixed (QueryHit* into = &hit) {
      result = Native.tandem_query_ray(handle, origin, direction, maxDistance, &native, into,
                                       (UIntPtr)1, &count, &error);
    }
    if (End(result, count, ref error, outer) > 0) return true;
    hit = default(QueryHit);
    return false;
  }

  /// <summary>A convex shape moves from `start` by `displacement` (m) without turning.</summary>
  public int Cast(Shape shape, Pose start, Vec3 displacement, QueryHit[] into,
                  QueryFilter? filter = null) {
    if (shape == null) throw new ArgumentNullException(nameof(shape));
    var native = Begin(filter, out var outer);
    UIntPtr count;
    NativeError error;
    Result result;
    fixed (Vec3* points = shape.Points)
    fixed (QueryHit* hits = into) {
      var asked = shape.At(points, null, null);
      result = Native.tandem_query_cast(handle, &asked, &start, displacement, &native, hits,
                                        Capacity(into), &count, &error);
    }
    return End(result, count, ref error, outer);
  }

  /// <summary>The closest colliders, up to `maxDistance` (m, >= 0).</summary>
  /// <param name="shape">convex; null: a point</param>
  public int Closest(Shape shape, Pose pose, double maxDistance, QueryHit[] into,
                     QueryFilter? filter = null) {
    var native = Begin(filter, out var outer);
    UIntPtr count;
    NativeError error;
    Result result;
    fixed (Vec3* points = shape?.Points)
    fixed (QueryHit* hits = into) {
      var asked = shape == null ? default(NativeShape) : shape.At(points, null, null);
      result = Native.tandem_query_closest(handle, shape == null ? null : &asked, &pose,
                                           maxDistance, &native, hits, Capacity(into), &count,
                                           &error);
    }
    return End(result, count, ref error, outer);
  }

  /// <summary>Colliders that share a point with the shape, in ascending order.</summary>
  /// <param name="shape">convex</param>
  public int Overlap(Shape shape, Pose pose, ColliderId[] into, QueryFilter? filter = null) {
    if (shape == null) throw new ArgumentNullException(nameof(shape));
    var native = Begin(filter, out var outer);
    UIntPtr count;
    NativeError error;
    Result result;
    fixed (Vec3* points = shape.Points)
    fixed (ColliderId* colliders = into) {
      var asked = shape.At(points, null, null);
      result = Native.tandem_query_overlap(handle, &asked, &pose, &native, colliders,
                                           Capacity(into), &count, &error);
    }
    return End(result, count, ref error, outer);
  }

  private static UIntPtr Capacity(Array into) => (UIntPtr)(into == null ? 0 : into.Length);

  // A filter's Accept may use the same query.
  private struct Asking {
    public Func<ColliderId, bool> Accept;
    public Exception Failure;
  }

  private NativeQueryFilter Begin(QueryFilter? filter, out Asking outer) {
    var from = filter ?? QueryFilter.Default;
    outer = new Asking {Accept = accept, Failure = failure};
    accept = from.Accept;
    failure = null;
    return new NativeQueryFilter {Category = from.Category,
                                  Mask = from.Mask,
                                  Group = from.Group,
                                  Ignore = from.Ignore,
                                  Sensors = from.Sensors ? 1 : 0,
                                  BackFaces = from.BackFaces ? 1 : 0,
                                  Accept = accept == null ? IntPtr.Zero : acceptPointer,
                                  User = GCHandle.ToIntPtr(handle.User)};
  }

  private int End(Result result, UIntPtr count, ref NativeError error, Asking outer) {
    accept = outer.Accept;
    var thrown = failure;
    failure = outer.Failure;
    if (thrown != null) {
      throw new InvalidOperationException("QueryFilter.Accept has thrown", thrown);
    }
    Native.Check(result, ref error);
    return (int)count;
  }

  [MonoPInvokeCallback(typeof(AcceptFunction))]
  private static int AcceptCollider(IntPtr user, ColliderId collider) {
    var query = GCHandle.FromIntPtr(user).Target as Query;
    if (query == null || query.failure != null) return 0;
    try {
      return query.accept(collider) ? 1 : 0;
    } catch (Exception thrown) {
      query.failure = thrown;  // it must not pass through the library
      return 0;
    }
  }
}

}  // namespace Tandem
