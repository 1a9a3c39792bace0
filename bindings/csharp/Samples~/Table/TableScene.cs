// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
using System.Collections.Generic;
using Tandem;
using UnityEngine;

/// <summary>Put it on an empty GameObject and play: two people carry a table. Both are in this
/// process, each with a world and a session of its own, two metres apart so that both copies are
/// seen; or one is, and the other in another process that connects to this one.</summary>
public sealed class TableScene : MonoBehaviour {
  [Tooltip("Both people in this process; else the one that Self says.")]
  public bool both = true;
  [Tooltip("1 listens, 2 connects.")]
  public int self = 1;
  public int port = 7777;
  [Tooltip("Where 1 is. Other machines want a session key: see Credentials.")]
  public string host = "localhost";
  [Tooltip("m/s")]
  public float speed = 0.7f;

  private sealed class Person {
    internal TableRoom Room;
    internal Transform Shown;
    internal KeyCode Left, Right, Away, Near, Up, Down, Take;
  }

  private readonly List<Person> people = new List<Person>();

  private void Start() {
    if (both || self == 1) people.Add(First());
    if (both || self == 2) people.Add(Second());
  }

  private Person First() => new Person {
      Room = new TableRoom(
          world => new Session(world, new TcpOptions {
              Self = 1, ListenPort = port, ListenAddress = "127.0.0.1"}),
          -1),
      Shown = Build(new Vector3(0, 0, -1)),
      Left = KeyCode.A, Right = KeyCode.D, Away = KeyCode.W, Near = KeyCode.S,
      Up = KeyCode.E, Down = KeyCode.Q, Take = KeyCode.Space};

  private Person Second() => new Person {
      Room = new TableRoom(
          world => new Session(world, new TcpOptions {
              Self = 2, Connect = new[] {host + ":" + port}}),
          1),
      Shown = Build(new Vector3(0, 0, 1)),
      Left = KeyCode.J, Right = KeyCode.L, Away = KeyCode.I, Near = KeyCode.K,
      Up = KeyCode.O, Down = KeyCode.U, Take = KeyCode.Return};

  private void Update() {
    foreach (var person in people) {
      var room = person.Room;
      if (Input.GetKeyDown(person.Take)) {
        if (room.Holds) room.LetGo(); else room.Take();
      }
      var way = new Vector3(Axis(person.Left, person.Right), Axis(person.Down, person.Up),
                            Axis(person.Near, person.Away));
      room.Hand += (speed * Time.deltaTime * way).ToTandem();
      room.Advance();
      person.Shown.localPosition = room.Pose.Position.ToUnity();
      person.Shown.localRotation = room.Pose.Orientation.ToUnity();
    }
  }

  private static float Axis(KeyCode less, KeyCode more) =>
      (Input.GetKey(more) ? 1f : 0f) - (Input.GetKey(less) ? 1f : 0f);

  /// <summary>A table to be seen; where it is, is for Tandem to say.</summary>
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
  }
}
