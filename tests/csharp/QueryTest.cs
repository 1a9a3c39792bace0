// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using Tandem;

internal static class QueryTest {
  internal static void Run() {
    using (var world = new World())
    using (var query = new Query(world)) {
      var ball = Shape.Sphere(0.5);
      var near = world.AddBody(BodyType.Static, ball, new Pose(3, 0, 0));
      var far = world.AddBody(BodyType.Static, ball, new Pose(6, 0, 0));
      var forward = new Vec3(2, 0, 0);
      var hits = new QueryHit[4];
      Check.That(query.Ray(Vec3.Zero, forward, 100, hits) == 0, "a query sees nothing new");
      query.Update();
      Check.That(query.Ray(Vec3.Zero, forward, 100, hits) == 2, "until it is updated");
      Check.That(hits[0].Body == near && hits[1].Body == far, "hits come by distance");
      Check.Near(hits[0].Distance, 2.5, 1e-9, "distance of a ball");
      Check.Near(hits[1].Normal.X, -1, 1e-9, "normal of a ball");
      Check.That(!query.Ray(Vec3.Zero, forward, 2.4, out var hit) && hit.Distance == 0.0,
                 "a ray ends");

      var filter = QueryFilter.Default;
      filter.Ignore = near;
      Check.That(query.Ray(Vec3.Zero, forward, 100, out hit, filter) && hit.Body == far,
                 "what is ignored is not seen");
      filter = QueryFilter.Default;
      var second = hits[1].Collider;
      filter.Accept = collider => collider == second;
      Check.That(query.Ray(Vec3.Zero, forward, 100, hits, filter) == 1 && hits[0].Body == far,
                 "what is not accepted is not seen");
      filter.Accept = collider => {
        var all = QueryFilter.Default;
        all.Accept = any => true;
        return query.Ray(Vec3.Zero, forward, 100, out hit, all) && hit.Collider == collider;
      };
      Check.That(query.Ray(Vec3.Zero, forward, 100, hits, filter) == 1 && hits[0].Body == near,
                 "a filter asks the same query");
      filter.Accept = collider => throw new InvalidCastException("no");
      Check.Throws<InvalidOperationException>(
          () => query.Ray(Vec3.Zero, forward, 100, hits, filter), "a filter that throws");
      Check.That(query.Ray(Vec3.Zero, forward, 100, null) > 0, "and it goes on after that");

      Check.That(query.Cast(ball, Pose.Identity, new Vec3(10, 0, 0), hits) == 2, "a cast hits");
      Check.Near(hits[0].Fraction, 0.2, 1e-6, "part of a ball's way to another");
      Check.That(query.Closest(null, Pose.Identity, 3, hits) == 1, "one is near");
      Check.Near(hits[0].Distance, 2.5, 1e-6, "distance of the nearest");
      Check.That(query.Closest(ball, Pose.Identity, 2.1, hits) == 1, "and to a ball");
      Check.Near(hits[0].Distance, 2, 1e-6, "distance of two balls");
      var inside = new ColliderId[2];
      Check.That(query.Overlap(Shape.Box(2, 2, 2), new Pose(5, 0, 0), inside) == 2 &&
                     inside[1] == second,
                 "what is in a box");
      Check.Refused(() => query.Ray(Vec3.Zero, Vec3.Zero, 1, hits), "direction");
    }
  }
}
