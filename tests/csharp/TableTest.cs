// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using Tandem;

/// <summary>The sample, without Unity: two people carry a table aside, over a link.</summary>
internal static class TableTest {
  internal static void Run() {
    const long start = 1000000000;
    using (var network = new Network(new Link {Latency = 0.03}, 1, start))
    using (var a = new TableRoom(network.Transport(1), -1))
    using (var b = new TableRoom(network.Transport(2), 1)) {
      var rooms = new[] {a, b};
      for (var k = 1; k <= 600; ++k) {
        var now = start + k * TableRoom.StepNs;
        network.Advance(now);
        if (k == 60) {
          Check.Near(a.Pose.Position.Z, TableRoom.Height, 1e-3, "height of a table that stands");
          foreach (var room in rooms) room.Take();
        }
        var t = (k - 60) / 60.0;
        foreach (var room in rooms) {
          if (t > 0 && t <= 2) room.Hand += new Vec3(0, 0, 0.3 / 60);
          if (t > 2 && t <= 5) room.Hand += new Vec3(0, 0.5 / 60, 0);
          room.Step(now);
        }
        if (k == 540) Carried(rooms);
      }
    }
  }

  /// <summary>Each hand bears half of 9.81 m on a spring of 4000 N/m.</summary>
  private static void Carried(TableRoom[] rooms) {
    var top = TableRoom.Top;
    var sag = 0.5 * 9.81 * (8 * top.X * top.Y * top.Z * 600) / 4000;
    foreach (var room in rooms) {
      Check.That(room.Holds, "a person holds");
      Check.Near(room.Pose.Position.Z, TableRoom.Height + 0.6 - sag, 0.02, "height of the table");
      Check.Near(room.Pose.Position.Y, 1.5, 0.02, "how far it was carried");
      Check.Near((room.Pose.Orientation * new Vec3(1, 0, 0)).Z, 0, 0.02, "its slope");
    }
    Check.Near((rooms[0].Pose.Position - rooms[1].Pose.Position).Length, 0, 1e-3,
               "between the two copies");
    foreach (var room in rooms) room.LetGo();
  }
}
