// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
// The few names of Unity's that the package uses, without what they do: they only show that the
// sources agree with these declarations.
using System;

namespace UnityEngine {

public struct Vector3 {
  public float x, y, z;

  public Vector3(float x, float y, float z) {
    this.x = x;
    this.y = y;
    this.z = z;
  }

  public static Vector3 operator *(float s, Vector3 v) => new Vector3(s * v.x, s * v.y, s * v.z);
}

public struct Quaternion {
  public float x, y, z, w;

  public Quaternion(float x, float y, float z, float w) {
    this.x = x;
    this.y = y;
    this.z = z;
    this.w = w;
  }
}

/// <summary>Unity has one too, which must not be confused with ours.</summary>
public struct Pose {}

public class Object {
  public static void Destroy(Object it) {}
}

public class Component : Object {
  public Transform transform => null;
}

public class Collider : Component {}
public class Joint : Component {}

public class MonoBehaviour : Component {}

public class Transform : Component {
  public Vector3 position { get; set; }
  public Quaternion rotation { get; set; }
  public Vector3 localPosition { get; set; }
  public Quaternion localRotation { get; set; }
  public Vector3 localScale { get; set; }
  public void SetParent(Transform parent, bool worldPositionStays) {}
  public void SetPositionAndRotation(Vector3 position, Quaternion rotation) {}
}

public sealed class GameObject : Object {
  public GameObject(string name) {}
  public Transform transform => null;
  public static GameObject CreatePrimitive(PrimitiveType type) => null;
  public T GetComponent<T>() => default(T);
}

public enum PrimitiveType { Cube }

public enum KeyCode { None, A, D, E, I, J, K, L, O, Q, S, U, W, Space, Return }

public static class Input {
  public static bool GetKey(KeyCode key) => false;
  public static bool GetKeyDown(KeyCode key) => false;
}

public static class Time {
  public static float deltaTime => 0f;
}

public sealed class TooltipAttribute : Attribute {
  public TooltipAttribute(string tooltip) {}
}

}  // namespace UnityEngine
