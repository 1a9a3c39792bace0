// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using Tandem;

/// <summary>One person's copy of a room with a table, which two people carry. Independent of
/// Unity.</summary>
public sealed class TableRoom : IDisposable {
  /// <summary>m: half edges of the top, and of a leg.</summary>
  public static readonly Vec3 Top = new Vec3(0.8, 0.4, 0.02), Leg = new Vec3(0.03, 0.03, 0.35);
  public static readonly Vec3[] Legs = {
      new Vec3(0.7, 0.3, -0.37), new Vec3(-0.7, 0.3, -0.37), new Vec3(0.7, -0.3, -0.37),
      new Vec3(-0.7, -0.3, -0.37)};
  /// <summary>m: height of the top's middle when the table stands.</summary>
  public const double Height = 0.72;

  /// <summary>ns, step length.</summary>
  public const long StepNs = 16666667;

  public readonly World World = new World();
  public readonly BodyId Table;
  private readonly Peer peer;
  private readonly SharedId shared;
  private readonly Vec3 attachment;
  private uint hand;

  /// <param name="transport">this person's, of a Network or your own</param>
  /// <param name="end">1 or -1: the end of the table that this person carries</param>
  public TableRoom(Transport transport, int end) {
    World.AddBody(BodyType.Static, Shape.Ground(), Pose.Identity);
    Table = World.AddBody(BodyType.Dynamic, Shape.Box(Top), new Pose(0, 0, Height), 600.0);
    foreach (var leg in Legs) {
      var collider = ColliderDef.Of(Table, Shape.Box(Leg));
      collider.Local = new Pose(leg, Quat.Identity);
      World.AddCollider(collider);
    }
    peer = new Peer(World, transport);
    shared = peer.Share("table", Table);
    attachment = new Vec3(end * Top.X, 0, 0);
    Hand = Pose.Position + attachment;
  }

  /// <summary>Pose of this copy.</summary>
  public Pose Pose => World.State(Table).Pose;

  /// <summary>m: position of this person's hand.</summary>
  public Vec3 Hand { get; set; }

  public bool Holds { get; private set; }

  /// <summary>Takes its end of the table; it moves with Hand from then on.</summary>
  public void Take() {
    if (Holds) return;
    var def = GrabDef.Default;
    def.Body = shared;
    def.Attachment = attachment;
    def.Anchor = Hand = Pose.Position + Pose.Orientation * attachment;
    def.Stiffness = 4000;
    def.Damping = 400;
    hand = peer.Grab(def);
    Holds = true;
  }

  public void LetGo() {
    if (Holds) peer.Release(hand);
    Holds = false;
  }

  /// <param name="nowNs">session time at which the step begins</param>
  public void Step(long nowNs) {
    if (Holds) peer.Move(hand, Hand, nowNs);
    peer.BeforeStep(nowNs);
    World.Step(1e-9 * StepNs);
    peer.AfterStep(nowNs + StepNs);
  }

  public void Dispose() {
    peer.Dispose();
    World.Dispose();
  }
}
