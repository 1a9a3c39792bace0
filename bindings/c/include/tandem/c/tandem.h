/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
#ifndef TANDEM_C_TANDEM_H
#define TANDEM_C_TANDEM_H

/**
 * @file
 * Tandem for languages that call C: worlds, bodies, shapes, joints, stepping, sharing over the
 * caller's transports, whole sessions over sockets, and scenes from files.
 *
 * TANDEM_C_API marks functions of the library tandem_c, TANDEM_C_SESSION_API those of
 * tandem_c_session, and TANDEM_C_FILES_API those of tandem_c_files: a program links those that it
 * calls.
 *
 * Units are m, kg, s, N, rad; quaternions are x, y, z, w, unit, body to world. Times of a session
 * are nanoseconds.
 *
 * Fill a def by its `_init` function and then change it, so that fields unknown to the program have
 * their defaults; fill structs without such a function with zeros first. Enums and truth values
 * have 32 bits. Handles are values with a generation: using one of a removed object is an error,
 * and never refers to another object.
 *
 * Errors: a function that can fail returns a tandem_result and writes field, value and rule to
 * `error`, which may be null. A failed call has changed nothing. No C++ exception leaves a
 * function. Functions without a result return 0 for a null object or a stale handle.
 *
 * Threads: distinct objects may be used at the same time, one object by one thread at a time. A
 * world counts as one object with its peer or session, its characters, cars and the like, and the
 * file that it came from; so does a network with all its transports and their peers.
 */

#include <stddef.h>
#include <stdint.h>

/* TANDEM_C_SHARED is for users of DLLs; the CMake targets and pkg-config files define it. The
 * others are defined where the library itself is built as a shared one. */
#if defined(_WIN32)
#define TANDEM_C_EXPORT __declspec(dllexport)
#if defined(TANDEM_C_SHARED)
#define TANDEM_C_IMPORT __declspec(dllimport)
#else
#define TANDEM_C_IMPORT
#endif
#elif defined(__GNUC__)
#define TANDEM_C_EXPORT __attribute__((visibility("default")))
#define TANDEM_C_IMPORT TANDEM_C_EXPORT
#else
#define TANDEM_C_EXPORT
#define TANDEM_C_IMPORT
#endif
#if defined(tandem_c_EXPORTS)
#define TANDEM_C_API TANDEM_C_EXPORT
#else
#define TANDEM_C_API TANDEM_C_IMPORT
#endif
#if defined(tandem_c_session_EXPORTS)
#define TANDEM_C_SESSION_API TANDEM_C_EXPORT
#else
#define TANDEM_C_SESSION_API TANDEM_C_IMPORT
#endif
#if defined(tandem_c_files_EXPORTS)
#define TANDEM_C_FILES_API TANDEM_C_EXPORT
#else
#define TANDEM_C_FILES_API TANDEM_C_IMPORT
#endif

/* Callers may pass unlisted values: they are checked, in C++ too. */
#ifdef __cplusplus
#define TANDEM_C_ENUM : int32_t
#else
#define TANDEM_C_ENUM
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** Changes with every incompatible change of this header. */
#define TANDEM_C_VERSION 2
/** TANDEM_C_VERSION of the library in use. */
TANDEM_C_API uint32_t tandem_c_version(void);

typedef enum tandem_result TANDEM_C_ENUM {
  TANDEM_OK = 0,
  TANDEM_INVALID_ARGUMENT = 1, /**< see the error's text */
  TANDEM_OUT_OF_MEMORY = 2,
  TANDEM_TOO_SMALL = 3, /**< the caller's buffer; the required size was written */
  TANDEM_FAILED = 4     /**< anything else */
} tandem_result;

/** An error, for people. */
typedef struct tandem_error {
  tandem_result result;
  char text[256]; /**< ends with 0; truncated if longer */
} tandem_error;

typedef struct tandem_vec3 {
  double x, y, z;
} tandem_vec3;

typedef struct tandem_quat {
  double x, y, z, w;
} tandem_quat;

typedef struct tandem_pose {
  tandem_vec3 position;
  tandem_quat orientation;
} tandem_pose;

typedef struct tandem_twist {
  tandem_vec3 linear;  /**< m/s, world */
  tandem_vec3 angular; /**< rad/s, world */
} tandem_twist;

typedef struct tandem_body {
  uint32_t index, generation;
} tandem_body;

typedef struct tandem_collider {
  uint32_t index, generation;
} tandem_collider;

typedef struct tandem_joint {
  uint32_t index, generation;
} tandem_joint;

/** The world, where a joint or an event names a body. */
#ifdef __cplusplus
#define TANDEM_NO_BODY (tandem_body{0xffffffffu, 0})
#else
#define TANDEM_NO_BODY ((tandem_body){0xffffffffu, 0})
#endif

/* ---- worlds ---- */

/** Bodies, shapes, joints, and the solver that steps them. */
typedef struct tandem_world tandem_world;

typedef struct tandem_world_def {
  tandem_vec3 gravity; /**< m/s^2; (0, 0, -9.81) */
  int32_t substeps;    /**< per step, 1 to 1000; 4 */
  int32_t threads;     /**< 1 to 64; 1. Any number gives the same bits. */
  double sleep_after;  /**< s; 0.5; 0 = never */
  int32_t events;      /**< not 0: contact events are collected; 0 */
} tandem_world_def;

typedef struct tandem_step_report {
  int32_t finite; /**< 0: a body became NaN or infinite and was reset */
  int32_t bodies;
  int32_t awake;
  int32_t targets; /**< bodies pulled by remote states */
} tandem_step_report;

TANDEM_C_API void tandem_world_def_init(tandem_world_def* def);
/** Null on failure. */
TANDEM_C_API tandem_world* tandem_world_create(const tandem_world_def* def, tandem_error* error);
/** Destroy it after its peer or session, queries, characters and the like. Null: no effect. */
TANDEM_C_API void tandem_world_destroy(tandem_world* world);
/** @param dt  s, 1e-5 to 1e6     @param report  may be null */
TANDEM_C_API tandem_result tandem_world_step(tandem_world* world, double dt,
                                             tandem_step_report* report, tandem_error* error);
TANDEM_C_API tandem_result tandem_world_set_gravity(tandem_world* world, tandem_vec3 gravity,
                                                    tandem_error* error);
/** Equal for bitwise equal worlds. */
TANDEM_C_API uint64_t tandem_world_hash(const tandem_world* world);
/** Everything that the next step and its events depend on, except the footing and jump of a
 * character.
 * @param size  in: bytes of `buffer`, out: needed */
TANDEM_C_API tandem_result tandem_world_snapshot(const tandem_world* world, void* buffer,
                                                 size_t* size, tandem_error* error);
/** Restores a snapshot of a world that was built the same way. The input is untrusted. */
TANDEM_C_API tandem_result tandem_world_restore(tandem_world* world, const void* bytes, size_t size,
                                                tandem_error* error);

/* ---- bodies ---- */

typedef enum tandem_body_type TANDEM_C_ENUM {
  TANDEM_STATIC = 0,
  TANDEM_KINEMATIC = 1, /**< moves with the given twist */
  TANDEM_DYNAMIC = 2
} tandem_body_type;

typedef struct tandem_body_def {
  tandem_body_type type; /**< TANDEM_DYNAMIC */
  tandem_pose pose;      /**< of the centre of mass */
  tandem_twist twist;
  double mass;          /**< kg, > 0; 1 */
  double inertia[9];    /**< kg m^2, row by row, body frame, about the centre of mass; 0.4 I */
  double gravity_scale; /**< 1 */
  double linear_damping, angular_damping; /**< 1/s */
  int32_t bullet;                         /**< not 0: continuous collision detection; 0 */
  int32_t can_sleep;                      /**< 1 */
} tandem_body_def;

typedef struct tandem_state {
  tandem_pose pose;
  tandem_twist twist;
} tandem_state;

TANDEM_C_API void tandem_body_def_init(tandem_body_def* def);
TANDEM_C_API tandem_result tandem_body_add(tandem_world* world, const tandem_body_def* def,
                                           tandem_body* body, tandem_error* error);
/** Also removes its colliders and joints. */
TANDEM_C_API tandem_result tandem_body_remove(tandem_world* world, tandem_body body,
                                              tandem_error* error);
TANDEM_C_API int32_t tandem_body_exists(const tandem_world* world, tandem_body body);
TANDEM_C_API tandem_result tandem_body_state(const tandem_world* world, tandem_body body,
                                             tandem_state* state, tandem_error* error);
/** States of many bodies at once. */
TANDEM_C_API tandem_result tandem_body_states(const tandem_world* world, const tandem_body* bodies,
                                              size_t count, tandem_state* states,
                                              tandem_error* error);
TANDEM_C_API int32_t tandem_body_awake(const tandem_world* world, tandem_body body);
TANDEM_C_API tandem_result tandem_body_set_pose(tandem_world* world, tandem_body body,
                                                const tandem_pose* pose, tandem_error* error);
TANDEM_C_API tandem_result tandem_body_set_twist(tandem_world* world, tandem_body body,
                                                 const tandem_twist* twist, tandem_error* error);
/** The kinematic body arrives there in the next step. */
TANDEM_C_API tandem_result tandem_body_move_to(tandem_world* world, tandem_body body,
                                               const tandem_pose* pose, tandem_error* error);
/** Acts during the next step. @param point  m, world; null: the centre of mass */
TANDEM_C_API tandem_result tandem_body_apply_force(tandem_world* world, tandem_body body,
                                                   tandem_vec3 force, const tandem_vec3* point,
                                                   tandem_error* error);
TANDEM_C_API tandem_result tandem_body_apply_torque(tandem_world* world, tandem_body body,
                                                    tandem_vec3 torque, tandem_error* error);
/** Acts at once, N s. @param point  m, world; null: the centre of mass */
TANDEM_C_API tandem_result tandem_body_apply_impulse(tandem_world* world, tandem_body body,
                                                     tandem_vec3 impulse, const tandem_vec3* point,
                                                     tandem_error* error);

/* ---- shapes ---- */

typedef enum tandem_shape_kind TANDEM_C_ENUM {
  TANDEM_SPHERE = 0,     /**< radius */
  TANDEM_BOX = 1,        /**< half_extents */
  TANDEM_CAPSULE = 2,    /**< radius, half_height without caps; along z */
  TANDEM_CYLINDER = 3,   /**< radius, half_height; along z */
  TANDEM_CONE = 4,       /**< radius, half_height; apex up z */
  TANDEM_HALF_SPACE = 5, /**< normal, offset: solid where normal . x <= offset */
  TANDEM_HULL = 6,       /**< points: their convex hull */
  TANDEM_MESH = 7,       /**< points, triangles; for bodies that do not move */
  TANDEM_HEIGHTS = 8     /**< columns, rows, spacing, heights; for bodies that do not move */
} tandem_shape_kind;

/** Arrays are read during the call with the shape, and not kept. */
typedef struct tandem_shape {
  tandem_shape_kind kind;
  double radius, half_height;
  tandem_vec3 half_extents;
  tandem_vec3 normal;
  double offset;
  const tandem_vec3* points;
  size_t point_count;
  const uint32_t* triangles; /**< three indices each, counter-clockwise seen from outside */
  size_t triangle_count;
  uint32_t columns, rows;
  double spacing_x, spacing_y;
  const double* heights; /**< row by row */
} tandem_shape;

typedef struct tandem_mass {
  double mass;                /**< kg */
  tandem_vec3 centre_of_mass; /**< m, frame of the shape */
  double inertia[9];          /**< kg m^2, about the centre of mass, row by row */
} tandem_mass;

typedef struct tandem_collider_def {
  tandem_body body;
  tandem_shape shape;
  tandem_pose local;       /**< of the shape in the body's frame */
  double friction;         /**< 0.5 */
  double restitution;      /**< 0 to 1; 0 */
  uint32_t category, mask; /**< two collide if each one's category is in the other's mask; 1, all */
  int32_t group;           /**< equal and > 0: always collide, equal and < 0: never; 0 */
  int32_t sensor;          /**< not 0: makes no contacts, only events; 0 */
} tandem_collider_def;

TANDEM_C_API void tandem_shape_init(tandem_shape* shape, tandem_shape_kind kind);
/** @param density  kg/m^3, > 0 */
TANDEM_C_API tandem_result tandem_shape_mass(const tandem_shape* shape, double density,
                                             tandem_mass* mass, tandem_error* error);
TANDEM_C_API void tandem_collider_def_init(tandem_collider_def* def, tandem_shape_kind kind);
TANDEM_C_API tandem_result tandem_collider_add(tandem_world* world, const tandem_collider_def* def,
                                               tandem_collider* collider, tandem_error* error);
TANDEM_C_API tandem_result tandem_collider_remove(tandem_world* world, tandem_collider collider,
                                                  tandem_error* error);

/* ---- joints ---- */

typedef enum tandem_joint_kind TANDEM_C_ENUM {
  TANDEM_FIXED = 0,
  TANDEM_BALL = 1,
  TANDEM_HINGE = 2, /**< turns about the axis */
  TANDEM_SLIDER = 3 /**< moves along the axis */
} tandem_joint_kind;

typedef enum tandem_motor_mode TANDEM_C_ENUM {
  TANDEM_MOTOR_OFF = 0,
  TANDEM_MOTOR_VELOCITY = 1,
  TANDEM_MOTOR_POSITION = 2
} tandem_motor_mode;

/** Frames are attached at the bodies' present poses; all coordinates are 0 there. */
typedef struct tandem_joint_def {
  tandem_joint_kind kind;
  tandem_body a, b;   /**< a may be TANDEM_NO_BODY, the world */
  tandem_vec3 anchor; /**< m, world */
  tandem_vec3 axis;   /**< world; hinges and sliders; (1, 0, 0) */
  double compliance;  /**< m/N, of the locked coordinates, 0 = rigid; 0 */
  /* Hinges (rad, N m) and sliders (m, N): */
  int32_t limited; /**< not 0: between lower and upper; 0 */
  double lower, upper;
  tandem_motor_mode motor;              /**< TANDEM_MOTOR_OFF */
  double motor_target, motor_max_force; /**< 0; infinite */
  double break_force, break_torque;     /**< N, N m; 0 = never */
} tandem_joint_def;

TANDEM_C_API void tandem_joint_def_init(tandem_joint_def* def, tandem_joint_kind kind);
TANDEM_C_API tandem_result tandem_joint_add(tandem_world* world, const tandem_joint_def* def,
                                            tandem_joint* joint, tandem_error* error);
TANDEM_C_API tandem_result tandem_joint_remove(tandem_world* world, tandem_joint joint,
                                               tandem_error* error);
/** For a hinge or a slider. */
TANDEM_C_API tandem_result tandem_joint_set_motor(tandem_world* world, tandem_joint joint,
                                                  tandem_motor_mode mode, double target,
                                                  double max_force, tandem_error* error);
/** A motor with a spring and a damper: force stiffness (target - position) - damping speed
 * (TANDEM_MOTOR_POSITION), or damping (target - speed) (TANDEM_MOTOR_VELOCITY, with stiffness 0),
 * at most max_force. N/m and N s/m, or N m/rad and N m s/rad. */
TANDEM_C_API tandem_result tandem_joint_set_servo(tandem_world* world, tandem_joint joint,
                                                  tandem_motor_mode mode, double target,
                                                  double stiffness, double damping,
                                                  double max_force, tandem_error* error);
/** rad or m of a hinge or a slider, 0 of others. @param broken  may be null */
TANDEM_C_API tandem_result tandem_joint_position(const tandem_world* world, tandem_joint joint,
                                                 double* position, int32_t* broken,
                                                 tandem_error* error);

/* ---- characters, cars, ropes, cloth, ragdolls ---- */

/* Each is made of bodies of a world. Destroying it removes them; destroy it before its world. If
 * the program removes one of its bodies itself, it can only be destroyed. Null: no effect. Lists of
 * bodies copy at most `capacity` and return the total number. */

/** As for a collider. */
typedef struct tandem_filter {
  uint32_t category, mask; /**< 1, all */
  int32_t group;           /**< 0: cars, ropes, cloth and ragdolls get one of their own */
} tandem_filter;

/** A capsule that walks, climbs steps and slopes, jumps, is carried, pushes and is pushed. */
typedef struct tandem_character tandem_character;

typedef struct tandem_character_def {
  double radius, half_height; /**< m, of the capsule, without caps; 0.3, 0.6 */
  tandem_vec3 position;       /**< m, world, of its centre; (0, 0, 1) */
  double mass;                /**< kg; 70 */
  double max_push;            /**< N, against obstacles; 400 */
  double max_slope;           /**< rad, 0 to 1.5: it slides down steeper ground; 0.87 */
  double max_step;            /**< m, up and down while staying on the ground; 0.35 */
  double air_acceleration;    /**< m/s^2, of the user's control in the air; 10 */
  double padding;             /**< m, below the radius: gap to everything; 0.02 */
  tandem_filter filter;
} tandem_character_def;

typedef enum tandem_footing TANDEM_C_ENUM {
  TANDEM_ON_GROUND = 0,
  TANDEM_ON_STEEP = 1, /**< slides down a slope above max_slope */
  TANDEM_IN_AIR = 2
} tandem_footing;

typedef struct tandem_character_state {
  tandem_body body;
  tandem_footing footing;    /**< after the last tandem_character_walk */
  tandem_body ground;        /**< the body below it; in the air TANDEM_NO_BODY */
  tandem_vec3 ground_normal; /**< unit, world; up in the air */
  tandem_vec3 velocity;      /**< m/s, world, including that of the ground */
} tandem_character_state;

TANDEM_C_API void tandem_character_def_init(tandem_character_def* def);
TANDEM_C_API tandem_character* tandem_character_create(tandem_world* world,
                                                       const tandem_character_def* def,
                                                       tandem_error* error);
TANDEM_C_API void tandem_character_destroy(tandem_character* character);
/** Call before each step. @param velocity  m/s, wanted, relative to the ground     @param dt  s, of
 * that step */
TANDEM_C_API tandem_result tandem_character_walk(tandem_character* character, tandem_vec3 velocity,
                                                 double dt, tandem_error* error);
/** The next walk leaves the ground, if it stands on some. @param speed  m/s, >= 0 */
TANDEM_C_API tandem_result tandem_character_jump(tandem_character* character, double speed,
                                                 tandem_error* error);
TANDEM_C_API tandem_result tandem_character_get_state(const tandem_character* character,
                                                      tandem_character_state* state,
                                                      tandem_error* error);

/** A chassis on four sprung wheels, all driven and braked, the front ones steered. */
typedef struct tandem_car tandem_car;

/** Its frame is the chassis': x forward, y left, z up. */
typedef struct tandem_car_def {
  tandem_pose pose;         /**< of the chassis; at (0, 0, 0.8) */
  tandem_vec3 half_extents; /**< m, of the chassis; (2, 0.8, 0.25) */
  double mass;              /**< kg, without wheels; 1200 */
  double wheelbase;         /**< m, between the axles; 2.6 */
  double track;             /**< m, between the wheels of an axle; 1.5 */
  double axle_height;       /**< m, of the axles in the frame, springs at rest; -0.4 */
  double wheel_radius;      /**< m; 0.35 */
  double wheel_width;       /**< m; 0.2 */
  double wheel_mass;        /**< kg; 20 */
  double stiffness;         /**< N/m, of each wheel's spring; 30e3 */
  double damping;           /**< N s/m; 3e3 */
  double travel;            /**< m, either way from rest; 0.25 */
  double friction;          /**< of tyres; 0.9 */
  double drive_torque;      /**< N m, in total; 1600 */
  double brake_torque;      /**< N m, in total; 8000 */
  double top_speed;         /**< m/s, limits the wheels' spin; 40 */
  double max_steer;         /**< rad, 0 to 1.5; 0.6 */
  tandem_filter filter;
} tandem_car_def;

TANDEM_C_API void tandem_car_def_init(tandem_car_def* def);
TANDEM_C_API tandem_car* tandem_car_create(tandem_world* world, const tandem_car_def* def,
                                           tandem_error* error);
TANDEM_C_API void tandem_car_destroy(tandem_car* car);
/** Holds until the next call.
 * @param throttle  -1, backwards, to 1
 * @param steer  rad, to the left, of a virtual wheel between the front ones
 * @param brake  0 to 1; above 0 the drive is off */
TANDEM_C_API tandem_result tandem_car_drive(tandem_car* car, double throttle, double steer,
                                            double brake, tandem_error* error);
/** Forward speed of the chassis, m/s; 0 if the chassis was removed. */
TANDEM_C_API double tandem_car_speed(const tandem_car* car);
/** The chassis, then the wheels: front left, front right, rear left, rear right. */
TANDEM_C_API size_t tandem_car_bodies(const tandem_car* car, tandem_body* bodies, size_t capacity);

/** Attaches a particle of a rope or a cloth to a body. */
typedef struct tandem_attachment {
  uint64_t number; /**< never reused; 0 = none */
} tandem_attachment;

/** Releases the particle, which still collides with nothing. */
TANDEM_C_API tandem_result tandem_attachment_remove(tandem_world* world,
                                                    tandem_attachment attachment,
                                                    tandem_error* error);

/** A rope of point masses, each a body. */
typedef struct tandem_rope tandem_rope;

typedef struct tandem_rope_def {
  tandem_vec3 from, to;         /**< m, world; (0, 0, 0), (1, 0, 0) */
  double length;                /**< m, at least their distance; 0 = their distance; 0 */
  int32_t particles;            /**< at least 2, ends included; odd for a hanging rope; 20 */
  double mass;                  /**< kg, in total; 0.5 */
  double radius;                /**< m: particles collide as spheres of this size; 0.01 */
  double compliance;            /**< 1/N: strain per newton; 0 */
  double bending;               /**< N m^2: moment per curvature; 0 */
  double damping;               /**< 1/s, air drag; 0.1 */
  double friction, restitution; /**< 0.5, 0 */
  tandem_filter filter;
} tandem_rope_def;

TANDEM_C_API void tandem_rope_def_init(tandem_rope_def* def);
TANDEM_C_API tandem_rope* tandem_rope_create(tandem_world* world, const tandem_rope_def* def,
                                             tandem_error* error);
TANDEM_C_API void tandem_rope_destroy(tandem_rope* rope);
/** The particles, from one end to the other. */
TANDEM_C_API size_t tandem_rope_bodies(const tandem_rope* rope, tandem_body* bodies,
                                       size_t capacity);
/** Attach a particle at its present place to a body. From then on it collides with nothing.
 * @param attachment  may be null */
TANDEM_C_API tandem_result tandem_rope_attach(tandem_rope* rope, uint32_t particle,
                                              tandem_body host, tandem_attachment* attachment,
                                              tandem_error* error);

/** A rectangle of cloth of point masses, each a body. */
typedef struct tandem_cloth tandem_cloth;

/** Its frame is that of a flat rectangle with a corner at the origin: columns along x, rows along
 * y. */
typedef struct tandem_cloth_def {
  tandem_pose pose;
  double width, height;         /**< m, along x and y; 1, 1 */
  int32_t columns, rows;        /**< particles along x and y, at least 2; 20, 20 */
  double density;               /**< kg/m^2; 0.2 */
  double radius;                /**< m: particles collide as spheres of this size; 0.01 */
  double stretching;            /**< N/m, along the threads; 0 = rigid; 0 */
  double shearing;              /**< N/m, along the diagonals; 0 = none; 50 */
  double bending;               /**< N m: moment per metre of width and curvature; 1e-4 */
  double damping;               /**< 1/s, air drag; 0.2 */
  double friction, restitution; /**< 0.5, 0 */
  tandem_filter filter;
} tandem_cloth_def;

TANDEM_C_API void tandem_cloth_def_init(tandem_cloth_def* def);
TANDEM_C_API tandem_cloth* tandem_cloth_create(tandem_world* world, const tandem_cloth_def* def,
                                               tandem_error* error);
TANDEM_C_API void tandem_cloth_destroy(tandem_cloth* cloth);
/** The particles, row by row. */
TANDEM_C_API size_t tandem_cloth_bodies(const tandem_cloth* cloth, tandem_body* bodies,
                                        size_t capacity);
/** As tandem_rope_attach. */
TANDEM_C_API tandem_result tandem_cloth_attach(tandem_cloth* cloth, int32_t column, int32_t row,
                                               tandem_body host, tandem_attachment* attachment,
                                               tandem_error* error);
/** Keeps each particle within its distance of the nearest attached one, so that hanging cloth does
 * not stretch. Call it once, after attaching. */
TANDEM_C_API tandem_result tandem_cloth_tether(tandem_cloth* cloth, tandem_error* error);
/** A body at the mean of the cloth around a point, which can be held, pulled and shared.
 * @param u, v  0 to 1, along columns and rows
 * @param reach  m, above the distance of particles
 * @param share  above 0 and below 1: fraction of the mass there that moves from the particles to
 * the body */
TANDEM_C_API tandem_result tandem_cloth_add_handle(tandem_cloth* cloth, double u, double v,
                                                   double reach, double share, tandem_body* body,
                                                   tandem_error* error);

/** An unconscious person: eleven bodies on ten joints with human limits. */
typedef struct tandem_ragdoll tandem_ragdoll;

/** Its frame is between the feet: x forward, y left, z up. */
typedef struct tandem_ragdoll_def {
  tandem_pose pose;
  double height;                /**< m; 1.75 */
  double mass;                  /**< kg, in total; 70 */
  double damping;               /**< N m s/rad, of each joint; 2 */
  double friction, restitution; /**< 0.5, 0 */
  tandem_filter filter;
} tandem_ragdoll_def;

TANDEM_C_API void tandem_ragdoll_def_init(tandem_ragdoll_def* def);
TANDEM_C_API tandem_ragdoll* tandem_ragdoll_create(tandem_world* world,
                                                   const tandem_ragdoll_def* def,
                                                   tandem_error* error);
TANDEM_C_API void tandem_ragdoll_destroy(tandem_ragdoll* ragdoll);
/** Pelvis, chest, head, left upper arm and forearm, right upper arm and forearm, left thigh and
 * shin, right thigh and shin. */
TANDEM_C_API size_t tandem_ragdoll_bodies(const tandem_ragdoll* ragdoll, tandem_body* bodies,
                                          size_t capacity);

/* ---- events of the last step, if the world collects them ---- */

typedef struct tandem_contact {
  tandem_collider collider_a, collider_b;
  tandem_body body_a, body_b;
} tandem_contact;

/** Contacts that begin faster than 1 m/s. */
typedef struct tandem_hit {
  tandem_contact contact;
  tandem_vec3 point;  /**< m, world */
  tandem_vec3 normal; /**< unit, world, from a to b */
  double speed;       /**< m/s, of approach */
  double impulse;     /**< N s */
} tandem_hit;

typedef enum tandem_contact_list TANDEM_C_ENUM {
  TANDEM_BEGUN = 0,
  TANDEM_ENDED = 1,
  TANDEM_TOUCHING = 2,
  TANDEM_SENSOR_BEGUN = 3, /**< a is the sensor */
  TANDEM_SENSOR_ENDED = 4,
  TANDEM_IN_SENSOR = 5
} tandem_contact_list;

/** Copies at most `capacity` contacts. @return the total number */
TANDEM_C_API size_t tandem_world_contacts(const tandem_world* world, tandem_contact_list list,
                                          tandem_contact* contacts, size_t capacity);
TANDEM_C_API size_t tandem_world_hits(const tandem_world* world, tandem_hit* hits, size_t capacity);

/* ---- queries ---- */

/** Rays, casts, overlaps and closest points among the colliders of a world, as of the last update.
 * They do not affect the simulation. */
typedef struct tandem_query tandem_query;

/** Returns not 0 if a query accepts this collider; called for candidates, in any order. */
typedef int32_t (*tandem_accept)(void* user, tandem_collider collider);

/** Which colliders a query sees. A null filter is the default. */
typedef struct tandem_query_filter {
  uint32_t category, mask; /**< as for a collider; all, all */
  int32_t group;           /**< as for a collider; 0 */
  tandem_body ignore;      /**< skip all colliders of that body; TANDEM_NO_BODY */
  int32_t sensors;         /**< not 0: include sensors; 0 */
  int32_t back_faces;      /**< not 0: back faces of triangles stop rays and casts too; 0 */
  tandem_accept accept;    /**< null: all */
  void* user;              /**< first argument of accept */
} tandem_query_filter;

typedef struct tandem_query_hit {
  tandem_collider collider;
  tandem_body body;
  tandem_vec3 point;  /**< m, world, on the collider */
  tandem_vec3 normal; /**< unit, world, out of the collider */
  double distance;    /**< m: along a ray; to the closest point; below 0: overlap */
  double fraction;    /**< along a ray or a cast, 0 to 1; else 0 */
  uint32_t triangle;  /**< of a mesh; else 0xffffffff */
} tandem_query_hit;

/** The world must outlive it. It sees the world as of the call. Null on failure. */
TANDEM_C_API tandem_query* tandem_query_create(const tandem_world* world, tandem_error* error);
/** Null: no effect. */
TANDEM_C_API void tandem_query_destroy(tandem_query* query);
/** Update the query to the present bodies and colliders. */
TANDEM_C_API tandem_result tandem_query_update(tandem_query* query, tandem_error* error);
TANDEM_C_API void tandem_query_filter_init(tandem_query_filter* filter);

/* Hits are sorted by distance, one per collider. At most `capacity` are written to `hits`, which
 * may be null if it is 0. `count` is the total number; with a capacity of at most 1 it only tells
 * whether there is any. Query shapes are convex. */

/** @param direction  of any length above 0     @param max_distance  m, > 0 */
TANDEM_C_API tandem_result tandem_query_ray(const tandem_query* query, tandem_vec3 origin,
                                            tandem_vec3 direction, double max_distance,
                                            const tandem_query_filter* filter,
                                            tandem_query_hit* hits, size_t capacity, size_t* count,
                                            tandem_error* error);
/** The shape moves from `start` by `displacement` (m) without turning. */
TANDEM_C_API tandem_result tandem_query_cast(const tandem_query* query, const tandem_shape* shape,
                                             const tandem_pose* start, tandem_vec3 displacement,
                                             const tandem_query_filter* filter,
                                             tandem_query_hit* hits, size_t capacity, size_t* count,
                                             tandem_error* error);
/** The closest colliders, up to `max_distance` (m, >= 0). @param shape  null: a point */
TANDEM_C_API tandem_result tandem_query_closest(const tandem_query* query,
                                                const tandem_shape* shape, const tandem_pose* pose,
                                                double max_distance,
                                                const tandem_query_filter* filter,
                                                tandem_query_hit* hits, size_t capacity,
                                                size_t* count, tandem_error* error);
/** Colliders that share a point with the shape, in ascending order. */
TANDEM_C_API tandem_result tandem_query_overlap(const tandem_query* query,
                                                const tandem_shape* shape, const tandem_pose* pose,
                                                const tandem_query_filter* filter,
                                                tandem_collider* colliders, size_t capacity,
                                                size_t* count, tandem_error* error);

/* ---- transports ---- */

/** Carries bytes between peers. */
typedef struct tandem_transport tandem_transport;

typedef enum tandem_delivery TANDEM_C_ENUM {
  TANDEM_NEWEST = 0,  /**< may be lost */
  TANDEM_RELIABLE = 1 /**< in order, all of them */
} tandem_delivery;

/** Accepts a packet; the bytes are copied. @param inbox  as passed to the transport */
typedef void (*tandem_receive)(void* inbox, uint64_t from, const void* bytes, size_t size);
/** Accepts a present or former peer. @param list  as passed to the transport */
typedef void (*tandem_list_peer)(void* list, uint64_t peer, int32_t connected);

/** A transport of the caller's. Its functions are called only during tandem_peer_ and
 * tandem_session_ functions, on their thread, and must not call back into the peer, the session or
 * its world. */
typedef struct tandem_transport_def {
  void* user;    /**< first argument of all functions */
  uint64_t self; /**< this peer; unique in the session, never 0 */
  /** Returns not 0 if it accepted the bytes, at most max_packet of them. Must not block. */
  int32_t (*post)(void* user, uint64_t to, const void* bytes, size_t size,
                  tandem_delivery delivery);
  /** Calls receive(inbox, ...) for each packet received since the last call, as it was posted. */
  void (*drain)(void* user, tandem_receive receive, void* inbox);
  /** Calls list(into, ...) for each peer ever seen, by ascending id. */
  void (*peers)(void* user, tandem_list_peer list, void* into);
  /** Disconnect a peer that sends undecodable packets. May be null. */
  void (*drop)(void* user, uint64_t peer, const char* reason);
  /** Bytes of the longest packet that post accepts, reliable or not: 512 to 61440; 0 is 61440.
   * Messages are split accordingly. */
  size_t max_packet;
} tandem_transport_def;

TANDEM_C_API tandem_transport* tandem_transport_create(const tandem_transport_def* def,
                                                       tandem_error* error);
/** Destroy it after its peer or session. Null: no effect. */
TANDEM_C_API void tandem_transport_destroy(tandem_transport* transport);

/** A network between peers of one process, in virtual time: for tests. */
typedef struct tandem_network tandem_network;

typedef struct tandem_link {
  double latency, jitter; /**< s, one way */
  double loss;            /**< probability that a state is lost */
  double bandwidth;       /**< bit/s; 0 = unlimited */
} tandem_link;

TANDEM_C_API tandem_network* tandem_network_create(const tandem_link* link, uint64_t seed,
                                                   int64_t start_ns, tandem_error* error);
/** Destroys its transports too; call it after destroying all peers on it. */
TANDEM_C_API void tandem_network_destroy(tandem_network* network);
/** Owned by the network. */
TANDEM_C_API tandem_transport* tandem_network_transport(tandem_network* network, uint64_t peer,
                                                        tandem_error* error);
/** Deliver packets that are due. @param time_ns  never decreases */
TANDEM_C_API tandem_result tandem_network_advance(tandem_network* network, int64_t time_ns,
                                                  tandem_error* error);

/* ---- messages of the application ---- */

/** Events between peers, by topic: each arrives once, those of a sender in order, despite losses
 * and broken connections. All members of a session use a channel, or none does. */
typedef struct tandem_channel tandem_channel;

typedef struct tandem_event {
  uint64_t from;
  int64_t stamp_ns;    /**< session time at which it was sent */
  const char* topic;   /**< ends with 0, and may contain more zeros; untrusted, like the payload */
  size_t topic_size;   /**< bytes */
  const void* payload; /**< valid until the next poll */
  size_t payload_size; /**< bytes */
} tandem_event;

/** The transport must outlive it. */
TANDEM_C_API tandem_channel* tandem_channel_create(tandem_transport* transport,
                                                   tandem_error* error);
/** Destroy it after the peer on its transport. Null: no effect. */
TANDEM_C_API void tandem_channel_destroy(tandem_channel* channel);
/** The transport to give to the peer; owned by the channel. Null for a null channel. */
TANDEM_C_API tandem_transport* tandem_channel_transport(tandem_channel* channel);
/** Call before each tandem_peer_before_step. */
TANDEM_C_API tandem_result tandem_channel_poll(tandem_channel* channel, int64_t now_ns,
                                               tandem_error* error);
/** Stamped with the time of the last poll. @param topic  at most 64 bytes     @param to  0: all */
TANDEM_C_API tandem_result tandem_channel_send(tandem_channel* channel, const char* topic,
                                               const void* payload, size_t size, uint64_t to,
                                               tandem_error* error);
/** Copies at most `capacity` events of the last poll. @return the total number */
TANDEM_C_API size_t tandem_channel_events(const tandem_channel* channel, tandem_event* events,
                                          size_t capacity);

/* ---- sharing ---- */

/** One participant of a session: shares bodies of a world with those of the other peers. */
typedef struct tandem_peer tandem_peer;

typedef struct tandem_peer_def {
  double update_hz;      /**< states sent per second; 60 */
  double influence;      /**< fraction of a difference closed per 1/60 s; 0.08 */
  double authority_ramp; /**< s, over which a newcomer gains influence; 1 */
  int32_t compact;   /**< not 0: states are rounded (0.12 mm) and take about 27 bytes, not 93; 0 */
  double tolerance;  /**< m: largest prediction error that is not corrected; 0 = send all */
  double kbit_per_s; /**< largest rate to each peer; 0 = no limit */
  double replay_budget; /**< replayed steps allowed per step, at least 1; 4 */
} tandem_peer_def;

typedef struct tandem_shared_id {
  uint64_t high, low;
} tandem_shared_id;

typedef struct tandem_grab_def {
  tandem_shared_id body;
  tandem_vec3 attachment;               /**< m, frame of the body */
  tandem_vec3 anchor;                   /**< m, world: the hand */
  double stiffness, damping, max_force; /**< N/m, N s/m, N; 500, 20, 1e6 */
} tandem_grab_def;

/** An instantaneous act on a shared body: pose and twist change only if set, impulses are added. */
typedef struct tandem_act_def {
  tandem_shared_id body;
  tandem_vec3 impulse;         /**< N s, world, at the centre of mass */
  tandem_vec3 angular_impulse; /**< N m s, world */
  int32_t sets_pose;           /**< not 0: to `pose`; 0 */
  int32_t sets_twist;          /**< not 0: to `twist`; 0 */
  tandem_pose pose;
  tandem_twist twist;
  uint64_t name; /**< acts on a body under one name within 1 s count once, by any peer; 0 = none */
} tandem_act_def;

typedef struct tandem_peer_stats {
  uint64_t updates_received, packets_received, packets_rejected, bytes_sent, bodies_placed;
} tandem_peer_stats;

TANDEM_C_API void tandem_peer_def_init(tandem_peer_def* def);
TANDEM_C_API tandem_peer* tandem_peer_create(tandem_world* world, tandem_transport* transport,
                                             const tandem_peer_def* def, tandem_error* error);
/** Destroy it before its world and its transport. Null: no effect. */
TANDEM_C_API void tandem_peer_destroy(tandem_peer* peer);
/** The id of a name; the same on every machine. */
TANDEM_C_API tandem_shared_id tandem_shared_id_of(const char* name);
/** @param owner  the peer that alone moves it; 0 = none */
TANDEM_C_API tandem_result tandem_peer_share(tandem_peer* peer, tandem_shared_id id,
                                             tandem_body body, uint64_t owner, tandem_error* error);
TANDEM_C_API tandem_result tandem_peer_unshare(tandem_peer* peer, tandem_shared_id id,
                                               tandem_error* error);
/* Each step: tandem_peer_before_step(now), tandem_world_step(dt), tandem_peer_after_step(now + dt),
 * with session times in ns, above 0. */
TANDEM_C_API tandem_result tandem_peer_before_step(tandem_peer* peer, int64_t now_ns,
                                                   tandem_error* error);
TANDEM_C_API tandem_result tandem_peer_after_step(tandem_peer* peer, int64_t now_ns,
                                                  tandem_error* error);
/** Tells the other peers to release this one's springs. */
TANDEM_C_API tandem_result tandem_peer_leave(tandem_peer* peer, int64_t now_ns,
                                             tandem_error* error);
TANDEM_C_API void tandem_grab_def_init(tandem_grab_def* def);
/** Hold a shared body with a spring that all peers simulate. */
TANDEM_C_API tandem_result tandem_peer_grab(tandem_peer* peer, const tandem_grab_def* def,
                                            uint32_t* grab, tandem_error* error);
/** @param now_ns  the start of the step to come */
TANDEM_C_API tandem_result tandem_peer_move(tandem_peer* peer, uint32_t grab, tandem_vec3 anchor,
                                            int64_t now_ns, tandem_error* error);
TANDEM_C_API tandem_result tandem_peer_release(tandem_peer* peer, uint32_t grab,
                                               tandem_error* error);
TANDEM_C_API void tandem_act_def_init(tandem_act_def* def);
/** Act on a shared body, here and, as of the same session time, at all peers. Call it between
 * steps. */
TANDEM_C_API tandem_result tandem_peer_act(tandem_peer* peer, const tandem_act_def* def,
                                           tandem_error* error);
TANDEM_C_API void tandem_peer_get_stats(const tandem_peer* peer, tandem_peer_stats* stats);

/* ---- sessions: library tandem_c_session ---- */

/** One participant of a session with all its parts: clock, steps of fixed length, peer, transport,
 * events. It steps its world, which no other code may step meanwhile:
 *
 *     tandem_session* session = tandem_session_create_tcp(world, &tcp, &def, &error);
 *     tandem_session_share(session, "cube", cube, 0, NULL, &error);
 *     each frame:  tandem_session_advance(session, tandem_session_now(session), ...);
 *
 * Callbacks must not let exceptions out, nor advance or destroy the session. */
typedef struct tandem_session tandem_session;

/** Makes the body that `what` describes, which comes from another member (untrusted: any bytes,
 * followed by a 0) or from tandem_session_spawn. The session sets its pose.
 * @return not 0 if `body` was written; 0 if `what` is unknown */
typedef int32_t (*tandem_make)(void* user, const char* what, size_t size, tandem_body* body);
/** Removes a body made by tandem_make from the world. */
typedef void (*tandem_remove)(void* user, tandem_body body);
/** Session time, ns. */
typedef int64_t (*tandem_clock)(void* user);
/** Called before each step, which begins at `now_ns`: to move hands, push, read events. */
typedef void (*tandem_before_step)(void* user, int64_t now_ns);

typedef struct tandem_session_def {
  double rate;          /**< steps a second, 0.1 to 1e4; 60 */
  tandem_peer_def peer; /**< as of tandem_peer_def_init */
  /* For spawning; all members have both functions, or none has: */
  tandem_make make;            /**< null */
  tandem_remove remove;        /**< null */
  uint32_t max_spawned;        /**< bodies alive, of all members, > 0; 1024 */
  uint32_t max_spawned_of_one; /**< bodies alive, of one member; 256 */
  tandem_clock clock;          /**< null: the transport's, if it has one, else the system's clock */
  void* user;                  /**< first argument of the three */
} tandem_session_def;

/** A session key, or an X25519 key of a peer. */
typedef struct tandem_key {
  uint8_t bytes[32];
} tandem_key;

typedef struct tandem_trusted {
  uint64_t peer;
  tandem_key public_key;
} tandem_trusted;

/** Who may take part in a protected session. Read during the call only. */
typedef struct tandem_credentials {
  const tandem_key* session_key; /**< the same for all members, not zero */
  const tandem_key* identity;    /**< secret of this peer; null = a new one */
  /** Accepted peers. With neither these nor an organiser: any member. */
  const tandem_trusted* trusted;
  size_t trusted_count;
  const tandem_key* organiser; /**< public key; its certificates admit peers; null = none */
  const void* certificate;     /**< of this peer, if there is an organiser */
  size_t certificate_size;     /**< bytes */
} tandem_credentials;

/** Options of one process in a session over TCP. */
typedef struct tandem_tcp_def {
  uint64_t self;              /**< unique in the session, never 0 */
  uint64_t scene_hash;        /**< peers with a different one are refused; 0 */
  int32_t listen_port;        /**< 0: a free one, see tandem_session_port; -1: dials only; -1 */
  int32_t insecure;           /**< not 0: allows other addresses than loopback without a key; 0 */
  const char* listen_address; /**< numeric; null: "0.0.0.0"; "::" is IPv6 and IPv4 */
  const char* connect; /**< "HOST:PORT" of peers, separated by spaces; one is enough; null: none */
  tandem_credentials credentials; /**< session_key may be null: loopback addresses only */
} tandem_tcp_def;

/** Source of session time. */
typedef enum tandem_clock_source TANDEM_C_ENUM {
  TANDEM_CLOCK_SESSION = 0, /**< agreed on in the session */
  TANDEM_CLOCK_SYSTEM = 1,  /**< hosts are disciplined by PTP or NTP */
  TANDEM_CLOCK_NONE = 2     /**< each peer has its own; states are dated on arrival */
} tandem_clock_source;

/** Options of one process in a session over UDP, which is always encrypted. */
typedef struct tandem_udp_def {
  uint64_t self;              /**< unique in the session, never 0 */
  uint64_t scene_hash;        /**< peers with a different one are refused; 0 */
  int32_t listen_port;        /**< 0: a free one, see tandem_session_port; 0 */
  tandem_clock_source clock;  /**< TANDEM_CLOCK_SESSION */
  const char* listen_address; /**< numeric; null: "0.0.0.0"; "::" is IPv6 and IPv4 */
  const char* connect; /**< "HOST:PORT" of peers, separated by spaces; one is enough; null: none */
  tandem_credentials credentials; /**< with a session key */
  double kbit_per_s;              /**< budget of each link, headers counted; 256 */
  int32_t relay; /**< not 0: forward for peers without a route, and be forwarded for; 1 */
} tandem_udp_def;

typedef enum tandem_step_status TANDEM_C_ENUM {
  TANDEM_STEP_OK = 0,
  TANDEM_STEP_NON_FINITE = 1, /**< a body became NaN or infinite and was reset */
  TANDEM_STEP_INVALID = 2     /**< session time is less than a step: none was made */
} tandem_step_status;

/** Result of tandem_session_advance. */
typedef struct tandem_progress {
  int32_t steps;
  tandem_step_status status; /**< of the first step that was not TANDEM_STEP_OK */
  int64_t skipped_ns;        /**< of session time, skipped */
  int64_t lag_ns;            /**< by which the world is behind */
  int64_t held_ns;           /**< > 0: session time is behind by this, nothing moves */
  int32_t stepped_elsewhere; /**< not 0: other code has stepped the world since the last call */
} tandem_progress;

/** Another peer as the transport sees it. */
typedef struct tandem_member {
  uint64_t id;
  int32_t connected;
  char reason[128];  /**< why it is not connected; ends with 0, truncated if longer */
  double round_trip; /**< s, smoothed; -1 = unknown */
  double kbit_per_s; /**< capacity of the path now; 0 = unknown */
  uint64_t packets_in, packets_out, bytes_in, bytes_out;
} tandem_member;

typedef struct tandem_session_stats {
  tandem_peer_stats peer;
  uint64_t spawns_refused;  /**< other members' requests to spawn or despawn */
  uint64_t events_lost;     /**< because too many waited */
  uint64_t events_rejected; /**< packets that could not be decoded */
} tandem_session_stats;

/** A new key from the system's generator. An error in builds without libsodium. */
TANDEM_C_SESSION_API tandem_result tandem_key_make(tandem_key* key, tandem_error* error);
/** The public key to give to others. An error in builds without libsodium. */
TANDEM_C_SESSION_API tandem_result tandem_key_public(const tandem_key* identity, tandem_key* key,
                                                     tandem_error* error);

/** The peer id of a public key: only the owner of its secret can use it. 0 for a null key, and in
 * builds without libsodium. */
TANDEM_C_SESSION_API uint64_t tandem_key_peer(const tandem_key* public_key);

TANDEM_C_SESSION_API void tandem_session_def_init(tandem_session_def* def);
TANDEM_C_SESSION_API void tandem_tcp_def_init(tandem_tcp_def* def);
TANDEM_C_SESSION_API void tandem_udp_def_init(tandem_udp_def* def);
/* The world must outlive it and have no peer. Null on failure. */
TANDEM_C_SESSION_API tandem_session* tandem_session_create_tcp(tandem_world* world,
                                                               const tandem_tcp_def* tcp,
                                                               const tandem_session_def* def,
                                                               tandem_error* error);
/** Fails in builds without libsodium. */
TANDEM_C_SESSION_API tandem_session* tandem_session_create_udp(tandem_world* world,
                                                               const tandem_udp_def* udp,
                                                               const tandem_session_def* def,
                                                               tandem_error* error);
/** With a transport that outlives it, a network's or the caller's, but not a channel's: a session
 * has its own events. */
TANDEM_C_SESSION_API tandem_session* tandem_session_create(tandem_world* world,
                                                           tandem_transport* transport,
                                                           const tandem_session_def* def,
                                                           tandem_error* error);
/** Announces that it leaves. Destroy it before its world and its transport. Null: no effect. */
TANDEM_C_SESSION_API void tandem_session_destroy(tandem_session* session);

/** Id of this peer. */
TANDEM_C_SESSION_API uint64_t tandem_session_self(const tandem_session* session);
/** The port of its own socket; 0 if it has none. */
TANDEM_C_SESSION_API int32_t tandem_session_port(const tandem_session* session);
/** Session time now, ns. 0 for a null session. */
TANDEM_C_SESSION_API int64_t tandem_session_now(tandem_session* session);
/** Make the steps that are due at `now_ns`, and only those; never blocks. The first call begins.
 * The world's contacts are those of the last step.
 * @param before_step  may be null, like `user`, its first argument, and `progress` */
TANDEM_C_SESSION_API tandem_result tandem_session_advance(tandem_session* session, int64_t now_ns,
                                                          tandem_before_step before_step,
                                                          void* user, tandem_progress* progress,
                                                          tandem_error* error);

/** Share a body with all members that share one under the same name.
 * @param owner  the peer that alone moves it; 0 = none
 * @param id  its id, tandem_shared_id_of(name); may be null */
TANDEM_C_SESSION_API tandem_result tandem_session_share(tandem_session* session, const char* name,
                                                        tandem_body body, uint64_t owner,
                                                        tandem_shared_id* id, tandem_error* error);
/** Share all bodies of one object, as "name/0", "name/1" and so on, or none of them. */
TANDEM_C_SESSION_API tandem_result tandem_session_share_all(tandem_session* session,
                                                            const char* name,
                                                            const tandem_body* bodies, size_t count,
                                                            uint64_t owner, tandem_error* error);
TANDEM_C_SESSION_API tandem_result tandem_session_unshare(tandem_session* session,
                                                          tandem_shared_id id, tandem_error* error);
/** The local instance of a shared body. */
TANDEM_C_SESSION_API tandem_result tandem_session_body(const tandem_session* session,
                                                       tandem_shared_id id, tandem_body* body,
                                                       tandem_error* error);

/** Hold a shared body with a spring that all members simulate. */
TANDEM_C_SESSION_API tandem_result tandem_session_grab(tandem_session* session,
                                                       const tandem_grab_def* def, uint32_t* grab,
                                                       tandem_error* error);
/** Position of the hand when the next step begins, m, world.
 * @param holds  0: released, or its body is gone; may be null */
TANDEM_C_SESSION_API tandem_result tandem_session_move(tandem_session* session, uint32_t grab,
                                                       tandem_vec3 anchor, int32_t* holds,
                                                       tandem_error* error);
/** Release it, if it still holds. */
TANDEM_C_SESSION_API tandem_result tandem_session_release(tandem_session* session, uint32_t grab,
                                                          tandem_error* error);
/** As tandem_peer_act. */
TANDEM_C_SESSION_API tandem_result tandem_session_act(tandem_session* session,
                                                      const tandem_act_def* def,
                                                      tandem_error* error);

/** Make a body at every member, later ones included, and share it.
 * @param what  argument of tandem_make at every member, at most 512 bytes; UTF-8, for example
 * @param twist  null: at rest     @param id  may be null */
TANDEM_C_SESSION_API tandem_result tandem_session_spawn(tandem_session* session, const char* what,
                                                        const tandem_pose* pose,
                                                        const tandem_twist* twist,
                                                        tandem_shared_id* id, tandem_error* error);
/** Remove a body that any member has spawned, at every member. */
TANDEM_C_SESSION_API tandem_result tandem_session_despawn(tandem_session* session,
                                                          tandem_shared_id id, tandem_error* error);

/** Peers that connected during the last advance. Copies at most `capacity` ids, in order; within
 * tandem_before_step those up to that step. @return the total number */
TANDEM_C_SESSION_API size_t tandem_session_joined(const tandem_session* session, uint64_t* peers,
                                                  size_t capacity);
/** The same for peers that disconnected. */
TANDEM_C_SESSION_API size_t tandem_session_left(const tandem_session* session, uint64_t* peers,
                                                size_t capacity);
/** All peers ever seen, by ascending id. Copies at most `capacity`. @return the total number */
TANDEM_C_SESSION_API size_t tandem_session_members(tandem_session* session, tandem_member* members,
                                                   size_t capacity);

/** A message of the application. It leaves before the next step.
 * @param topic  at most 64 bytes; those that begin with "tandem." are reserved
 * @param to  0: all */
TANDEM_C_SESSION_API tandem_result tandem_session_send(tandem_session* session, const char* topic,
                                                       const void* payload, size_t size,
                                                       uint64_t to, tandem_error* error);
/** Events received during the last advance, within tandem_before_step those up to that step,
 * without the session's own. Valid until the next advance. Copies at most `capacity`.
 * @return the total number */
TANDEM_C_SESSION_API size_t tandem_session_events(const tandem_session* session,
                                                  tandem_event* events, size_t capacity);
TANDEM_C_SESSION_API void tandem_session_get_stats(const tandem_session* session,
                                                   tandem_session_stats* stats);

/* ---- scene files: library tandem_c_files ---- */

/** Names and other data of a file, beside the world made from it. */
typedef struct tandem_scene_file tandem_scene_file;

typedef enum tandem_scene_format TANDEM_C_ENUM {
  TANDEM_SCENE_JSON = 0, /**< Tandem's own, docs/scene_files.md */
  TANDEM_SCENE_GLTF = 1  /**< glTF 2.0 with physics, or .glb; its y is up, the world's z is */
} tandem_scene_format;

/** Valid as long as the file. */
typedef struct tandem_named_body {
  const char* name; /**< may be empty */
  tandem_body body;
} tandem_named_body;

typedef struct tandem_named_joint {
  const char* name; /**< may be empty */
  tandem_joint joint;
} tandem_named_joint;

/** A world from a file; names that end in .gltf or .glb are glTF. Files are untrusted. An error
 * names file, place in it, rule and value. Null on failure.
 * @param path  UTF-8
 * @param def  its gravity counts if the file has none
 * @param file  may be null; destroy it before or after the world */
TANDEM_C_FILES_API tandem_world* tandem_scene_load(const char* path, const tandem_world_def* def,
                                                   tandem_scene_file** file, tandem_error* error);
/** The same from text in memory.
 * @param size  bytes, without a 0 at the end
 * @param folder  for glTF, whose buffers may be files; UTF-8 */
TANDEM_C_FILES_API tandem_world* tandem_scene_parse(tandem_scene_format format, const char* text,
                                                    size_t size, const char* folder,
                                                    const tandem_world_def* def,
                                                    tandem_scene_file** file, tandem_error* error);
/** The world remains. Null: no effect. */
TANDEM_C_FILES_API void tandem_scene_file_destroy(tandem_scene_file* file);
/** In the file's order. Copies at most `capacity`. @return the total number */
TANDEM_C_FILES_API size_t tandem_scene_file_bodies(const tandem_scene_file* file,
                                                   tandem_named_body* bodies, size_t capacity);
TANDEM_C_FILES_API size_t tandem_scene_file_joints(const tandem_scene_file* file,
                                                   tandem_named_joint* joints, size_t capacity);
/** Parts of the file that the world lacks, with their places. */
TANDEM_C_FILES_API size_t tandem_scene_file_warnings(const tandem_scene_file* file,
                                                     const char** warnings, size_t capacity);
/** The first one of that name. */
TANDEM_C_FILES_API tandem_result tandem_scene_file_find_body(const tandem_scene_file* file,
                                                             const char* name, tandem_body* body,
                                                             tandem_error* error);
TANDEM_C_FILES_API tandem_result tandem_scene_file_find_joint(const tandem_scene_file* file,
                                                              const char* name, tandem_joint* joint,
                                                              tandem_error* error);
/** Present pose, world, of the frame of that name: for a body the frame of its shape, while
 * tandem_body_state has the centre of mass. */
TANDEM_C_FILES_API tandem_result tandem_scene_file_pose(const tandem_scene_file* file,
                                                        const char* name, tandem_pose* pose,
                                                        tandem_error* error);
/** Add a body, from an element of "bodies" in Tandem's format.
 * @param size  bytes, without a 0 at the end */
TANDEM_C_FILES_API tandem_result tandem_scene_add_body(tandem_world* world, const char* text,
                                                       size_t size, tandem_body* body,
                                                       tandem_error* error);
/** The world as text in Tandem's format, with a 0 at the end.
 * @param file  its names; null: none
 * @param size  in: bytes of `buffer`, out: needed */
TANDEM_C_FILES_API tandem_result tandem_scene_write(const tandem_world* world,
                                                    const tandem_scene_file* file, char* buffer,
                                                    size_t* size, tandem_error* error);

#undef TANDEM_C_ENUM

#ifdef __cplusplus
}
#endif

#endif
