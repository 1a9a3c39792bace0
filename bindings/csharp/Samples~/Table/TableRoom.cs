// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System;
using Tandem;

/// <summary>One person's copy of a room with a table: the other has one, too, and both carry it.
/// Nothing in here is Unity's.</summary>
public sealed class TableRoom : IDisposable {
  /// <summary>m: halves of the top's edges, and of a leg's.</summary>
  public static readonly Vec3 Top = new Vec3(0.8, 0.4, 0.02), Leg = new Vec3(0.03, 0.03, 0.35);
  public static readonly Vec3[] Legs = {
      new Vec3(0.7, 0.3, -0.37), new Vec3(-0.7, 0.3, -0.37), new Vec3(0.7, -0.3, -0.37),
      new Vec3(-0.7, -0.3, -0.37)};
  /// <summary>m: of the top's middle, where the table stands.</summary>
  public const double Height = 0.72;

  public readonly World World = new World();
  public readonly Session Session;
  public readonly BodyId Table;
  private readonly SharedId shared;
  private readonly Vec3 attachment;
  private readonly Action<long> beforeStep;
  private uint hand;

  /// <param name="join">makes the session of the world</param>
  /// <param name="end">1 or -1: the end of the table that this person carries</param>
  public TableRoom(Func<World, Session> join, int end) {
    World.AddBody(BodyType.Static, Shape.Ground(), Pose.Identity);
    Table = World.AddBody(BodyType.Dynamic, Shape.Box(Top), new Pose(0, 0, Height), 600.0);
    foreach (var leg in Legs) {
      var collider = ColliderDef.Of(Table, Shape.Box(Leg));
      collider.Local = new Pose(leg, Quat.Identity);
      World.AddCollider(collider);
    }
    Session = join(World);
    shared = Session.Share("table", Table);
    attachment = new Vec3(end * Top.X, 0, 0);
    Hand = World.State(Table).Pose.Position + attachment;
    beforeStep = now => {
      if (Holds) Holds = Session.Move(hand, Hand);
    };
  }

  /// <summary>Of this copy.</summary>
  public Pose Pose => World.State(Table).Pose;

  /// <summary>m: where this person's hand is.</summary>
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
    hand = Session.Grab(def);
    Holds = true;
  }

  public void LetGo() {
    if (Holds) Session.Release(hand);
    Holds = false;
  }

  /// <summary>Once in each frame.</summary>
  public void Advance() => Session.Advance(Session.Now, beforeStep);

  public void Dispose() {
    Session.Dispose();
    World.Dispose();
  }
}
