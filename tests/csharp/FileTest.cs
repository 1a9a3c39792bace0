// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System.IO;
using System.Linq;
using System.Text;
using Tandem;

internal static class FileTest {
  private const string room = @"{""gravity"": [0, 0, -1.62], ""bodies"": [
      {""name"": ""Boden"", ""type"": ""static"", ""shape"": {""type"": ""halfSpace""}},
      {""name"": ""tür"", ""shape"": {""type"": ""box"", ""halfExtents"": [0.4, 0.02, 1]},
       ""mass"": 20, ""position"": [3.4, 0, 1.5]}],
    ""joints"": [{""name"": ""hinge"", ""type"": ""hinge"", ""b"": ""tür"",
       ""at"": {""position"": [3, 0, 1.5], ""axis"": [0, 0, 1]}}]}";

  internal static void Run() {
    using (var file = SceneFile.Parse(SceneFormat.Json, Encoding.UTF8.GetBytes(room)))
    using (var world = file.World) {
      var bodies = file.Bodies();
      Check.That(bodies.Length == 2 && bodies[0].Name == "Boden" && bodies[1].Name == "tür" &&
                     bodies[1].Body == file.Body("tür"),
                 "bodies have their names");
      Check.That(file.Joints().Single().Name == "hinge" &&
                     file.Joints()[0].Joint == file.Joint("hinge") && file.Warnings().Length == 0,
                 "joints too");
      Check.Near(file.Pose("tür").Position.X, 3.4, 1e-12, "where a file puts one");
      Check.Refused(() => file.Body("Fenster"), "Fenster");
      var ball = SceneFile.AddBody(
          world, @"{""shape"": {""type"": ""sphere"", ""radius"": 0.5}, ""position"": [0, 9, 5]}");
      for (var i = 0; i < 60; ++i) world.Step(1.0 / 60);
      Check.Near(world.State(ball).Pose.Position.Z, 5 - 0.5 * 1.62, 0.01, "a second's fall on the moon");
      var text = file.Write();
      Check.That(text.Contains("tür") && text.TrimEnd().EndsWith("}") &&
                     !SceneFile.Write(world).Contains("tür"),
                 "names are written, with the file");
      using (var again = SceneFile.Parse(SceneFormat.Json, Encoding.UTF8.GetBytes(text)))
      using (again.World) {
        Check.Near(again.Pose("tür").Position.Z, 1.5, 1e-6, "what was written is read");
      }
    }
    var path = Path.GetTempFileName();
    try {
      File.WriteAllText(path, @"{""bodies"": [{""shape"": {""type"": ""sphere"", ""radius"": -1}}]}");
      Check.Refused(() => SceneFile.Load(path), "/bodies/0/shape");
      File.WriteAllText(path, room);
      using (var file = SceneFile.Load(path)) {
        file.World.Dispose();
        Check.That(file.Bodies().Length == 2, "a file outlives that somebody has let go of its world");
      }
    } finally {
      File.Delete(path);
    }
    Check.Throws<TandemException>(() => SceneFile.Load("there_is_none.json"), "no file");
  }
}
