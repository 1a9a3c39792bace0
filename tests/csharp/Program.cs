// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.IO;

internal static class Program {
  /// <summary>With what csharp_reference has printed.</summary>
  private static int Main(string[] arguments) {
    var reference = File.ReadAllLines(arguments[0]);
    Run("layout", () => LayoutTest.Run(reference));
    Run("frames", FrameTest.Run);
    Run("worlds", WorldTest.Run);
    Run("hashes", () => HashTest.Run(reference));
    Run("queries", QueryTest.Run);
    Run("sharing", SharingTest.Run);
    Run("sessions", SessionTest.Run);
    Run("table", TableTest.Run);
    Run("parts", PartTest.Run);
    Run("files", FileTest.Run);
    Run("lifetimes", LifetimeTest.Run);
    Run("cost", CostTest.Run);
    if (Check.Failures > 0) Console.Error.WriteLine($"{Check.Failures} claims do not hold");
    return Check.Failures > 0 ? 1 : 0;
  }

  private static void Run(string name, Action test) {
    var before = Check.Failures;
    try {
      test();
    } catch (Exception thrown) {
      Check.That(false, $"{name} ends without {thrown}");
    }
    Console.WriteLine($"{name}: {(Check.Failures == before ? "ok" : "FAILED")}");
  }
}
