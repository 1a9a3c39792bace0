// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;

namespace Tandem {

public enum Result {
  Ok = 0,
  InvalidArgument = 1,
  OutOfMemory = 2,
  TooSmall = 3,
  Failed = 4
}

/// <summary>A refused call, with the library's text: field, value and rule. Nothing has
/// changed.</summary>
public sealed class TandemException : Exception {
  public Result Result { get; }

  public TandemException(Result result, string message) : base(message) {
    Result = result;
  }
}

}  // namespace Tandem
