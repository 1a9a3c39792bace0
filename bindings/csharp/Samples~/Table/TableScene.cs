// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System.Collections.Generic;
using Tandem;
using UnityEngine;

/// <summary>Put it on an empty GameObject and play: two people carry a table. Each has a world,
/// with a link between them; both copies of the table are shown, two metres apart.</summary>
public sealed class TableScene : MonoBehaviour {
  [Tooltip("s, one way, between the two")]
  public float latency = 0.06f;
  [Tooltip("m/s")]
  public float speed = 0.7f;

  private sealed class Person {
    internal TableRoom Room;
    internal Transform Shown;
    internal KeyCode Left, Right, Away, Near, Up, Down, Take;
  }

  private readonly List<Person> people = new List<Person>();
  private Network network;
  private long now = 1000000000;  // ns
  private double due;             // s

  private void Start() {
    network = new Network(new Link {Latency = latency}, 1, now);
    people.Add(new Person {
        Room = new TableRoom(network.Transport(1), -1), Shown = Build(new Vector3(0, 0, -1)),
        Left = KeyCode.A, Right = KeyCode.D, Away = KeyCode.W, Near = KeyCode.S,
        Up = KeyCode.E, Down = KeyCode.Q, Take = KeyCode.Space});
    people.Add(new Person {
        Room = new TableRoom(network.Transport(2), 1), Shown = Build(new Vector3(0, 0, 1)),
        Left = KeyCode.J, Right = KeyCode.L, Away = KeyCode.I, Near = KeyCode.K,
        Up = KeyCode.O, Down = KeyCode.U, Take = KeyCode.Return});
  }

  private void Update() {
    foreach (var person in people) Lead(person);
    // At most what a slow frame can catch up with.
    due = System.Math.Min(due + Time.deltaTime, 0.1);
    const double dt = 1e-9 * TableRoom.StepNs;
    for (; due >= dt; due -= dt) {
      network.Advance(now);
      foreach (var person in people) person.Room.Step(now);
      now += TableRoom.StepNs;
    }
    foreach (var person in people) {
      var pose = person.Room.Pose;
      person.Shown.localPosition = pose.Position.ToUnity();
      person.Shown.localRotation = pose.Orientation.ToUnity();
    }
  }

  private void Lead(Person person) {
    var room = person.Room;
    if (Input.GetKeyDown(person.Take)) {
      if (room.Holds) room.LetGo(); else room.Take();
    }
    var way = new Vector3(Axis(person.Left, person.Right), Axis(person.Down, person.Up),
                          Axis(person.Near, person.Away));
    room.Hand += (speed * Time.deltaTime * way).ToTandem();
  }

  private static float Axis(KeyCode less, KeyCode more) =>
      (Input.GetKey(more) ? 1f : 0f) - (Input.GetKey(less) ? 1f : 0f);

  /// <summary>A visible table; Tandem sets its pose.</summary>
  private Transform Build(Vector3 place) {
    var room = new GameObject("Room").transform;
    room.SetParent(transform, false);
    room.localPosition = place;
    var table = new GameObject("Table").transform;
    table.SetParent(room, false);
    Cube(table, Vec3.Zero, TableRoom.Top);
    foreach (var leg in TableRoom.Legs) Cube(table, leg, TableRoom.Leg);
    return table;
  }

  private static void Cube(Transform parent, Vec3 at, Vec3 halfExtents) {
    var cube = GameObject.CreatePrimitive(PrimitiveType.Cube);
    Destroy(cube.GetComponent<Collider>());
    cube.transform.SetParent(parent, false);
    cube.transform.localPosition = at.ToUnity();
    cube.transform.localScale = 2f * halfExtents.ToUnity();
  }

  private void OnDestroy() {
    foreach (var person in people) person.Room.Dispose();
    people.Clear();
    network?.Dispose();
  }
}
