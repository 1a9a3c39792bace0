// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;

#pragma warning disable 0649  // the library writes to them

namespace Tandem {

public sealed class SessionOptions {
  public double Rate;   // steps a second, 0.1 to 1e4; 60
  public PeerDef Peer;  // PeerDef.Default
  public uint MaxSpawned;       // bodies alive, of all members, > 0; 1024
  public uint MaxSpawnedOfOne;  // bodies alive, of one member; 256

  /// <summary>Makes the body that a text describes, which comes from another member (untrusted) or
  /// from Session.Spawn; null: the text is unknown. The session sets its pose. All members have
  /// Make and Remove, or none has.</summary>
  public Func<string, BodyId?> Make;
  /// <summary>Removes a body made by Make from the world.</summary>
  public Action<BodyId> Remove;
  /// <summary>Session time, ns; null: the transport's, if it has one, else the system's
  /// clock.</summary>
  public Func<long> Clock;

  public SessionOptions() {
    Native.tandem_session_def_init(out var def);
    Rate = def.Rate;
    Peer = def.Peer;
    MaxSpawned = def.MaxSpawned;
    MaxSpawnedOfOne = def.MaxSpawnedOfOne;
  }
}

public enum StepStatus {
  Ok = 0,
  NonFinite = 1,  // a body became NaN or infinite and was reset
  Invalid = 2     // session time is less than a step: none was made
}

/// <summary>Result of Session.Advance.</summary>
[StructLayout(LayoutKind.Sequential)]
public struct Progress {
  public int Steps;
  public StepStatus Status;  // of the first step that was not Ok
  public long SkippedNs;     // of session time, skipped
  public long LagNs;         // by which the world is behind
  public long HeldNs;        // > 0: session time is behind by this, nothing moves
  private int steppedElsewhere;

  /// <summary>Other code has stepped the world since the last call.</summary>
  public bool SteppedElsewhere => steppedElsewhere != 0;
}

[StructLayout(LayoutKind.Sequential)]
public struct SessionStats {
  public PeerStats Peer;
  public ulong SpawnsRefused;   // other members' requests to spawn or despawn
  public ulong EventsLost;      // because too many waited
  public ulong EventsRejected;  // packets that could not be decoded
}

/// <summary>Another peer as the transport sees it.</summary>
public struct Member {
  public ulong Id;
  public bool Connected;
  public string Reason;     // why it is not connected
  public double RoundTrip;  // s, smoothed; -1 = unknown
  public double KbitPerS;   // capacity of the path now; 0 = unknown
  public ulong PacketsIn, PacketsOut, BytesIn, BytesOut;
}

/// <summary>The library's calls into a session's program.</summary>
internal sealed unsafe class SessionCalls {
  // Never collected, as the library has their addresses.
  private static readonly MakeFunction makeFunction = Make;
  private static readonly RemoveFunction removeFunction = Remove;
  private static readonly ClockFunction clockFunction = Clock;
  private static readonly BeforeStepFunction beforeStepFunction = BeforeStep;
  internal static readonly IntPtr BeforeStepPointer =
      Marshal.GetFunctionPointerForDelegate(beforeStepFunction);

  internal Action<long> OnStep;
  private readonly Func<string, BodyId?> make;
  private readonly Action<BodyId> remove;
  private readonly Func<long> clock;
  private Exception failure;

  internal SessionCalls(SessionOptions options) {
    make = options.Make;
    remove = options.Remove;
    clock = options.Clock;
  }

  internal NativeSessionDef Def(SessionOptions options, IntPtr user) {
    Native.tandem_session_def_init(out var def);
    def.Rate = options.Rate;
    def.Peer = options.Peer;
    def.MaxSpawned = options.MaxSpawned;
    def.MaxSpawnedOfOne = options.MaxSpawnedOfOne;
    if (make != null) def.Make = Marshal.GetFunctionPointerForDelegate(makeFunction);
    if (remove != null) def.Remove = Marshal.GetFunctionPointerForDelegate(removeFunction);
    if (clock != null) def.Clock = Marshal.GetFunctionPointerForDelegate(clockFunction);
    def.User = user;
    return def;
  }

  /// <summary>Call after each call of the library that may have called the program.</summary>
  internal void Rethrow() {
    if (failure == null) return;
    var thrown = failure;
    failure = null;
    throw new InvalidOperationException("what a session has called has thrown", thrown);
  }

  private static SessionCalls Of(IntPtr user) =>
      GCHandle.FromIntPtr(user).Target as SessionCalls;

  [MonoPInvokeCallback(typeof(MakeFunction))]
  private static int Make(IntPtr user, byte* what, UIntPtr size, BodyId* body) {
    var calls = Of(user);
    if (calls == null) return 0;  // the collector is freeing all of it
    try {
      var made = calls.make(Messages.Text(what, (int)size));
      if (made.HasValue) *body = made.Value;
      return made.HasValue ? 1 : 0;
    } catch (Exception thrown) {
      calls.failure = thrown;  // exceptions must not pass through the library
      return 0;
    }
  }

  [MonoPInvokeCallback(typeof(RemoveFunction))]
  private static void Remove(IntPtr user, BodyId body) {
    var calls = Of(user);
    if (calls == null) return;
    try {
      calls.remove(body);
    } catch (Exception thrown) {
      calls.failure = thrown;
    }
  }

  [MonoPInvokeCallback(typeof(ClockFunction))]
  private static long Clock(IntPtr user) {
    var calls = Of(user);
    if (calls == null) return 0;
    try {
      return calls.clock();
    } catch (Exception thrown) {
      calls.failure = thrown;
      return 0;
    }
  }

  [MonoPInvokeCallback(typeof(BeforeStepFunction))]
  private static void BeforeStep(IntPtr user, long nowNs) {
    var calls = Of(user);
    if (calls == null || calls.failure != null) return;
    try {
      calls.OnStep(nowNs);
    } catch (Exception thrown) {
      calls.failure = thrown;
    }
  }
}

}  // namespace Tandem
