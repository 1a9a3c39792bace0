// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using Tandem;

/// <summary>Counts what does not hold and goes on.</summary>
internal static class Check {
  internal static int Failures { get; private set; }

  internal static void That(bool holds, string claim) {
    if (holds) return;
    ++Failures;
    Console.Error.WriteLine($"does not hold: {claim}");
  }

  internal static void Near(double value, double expected, double tolerance, string what) =>
      That(Math.Abs(value - expected) <= tolerance,
           $"{what} is {value}, not {expected} within {tolerance}");

  /// <summary>What is refused is said in words that hold `part`.</summary>
  internal static void Refused(Action call, string part) {
    try {
      call();
    } catch (TandemException thrown) {
      That(thrown.Result == Result.InvalidArgument && thrown.Message.Contains(part),
           $"'{part}' is in '{thrown.Message}' ({thrown.Result})");
      return;
    }
    That(false, $"something is refused because of {part}");
  }

  internal static void Throws<T>(Action call, string what) where T : Exception {
    try {
      call();
    } catch (T) {
      return;
    }
    That(false, $"{what} throws {typeof(T).Name}");
  }
}
