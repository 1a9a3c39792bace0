// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Checks of input at the public edge of all libraries, and their error messages: field, rule and
// value.
#pragma once

#include <string>
#include <string_view>

#include "tandem/pbd/body.h"
#include "tandem/pbd/export.h"

namespace tandem::pbd {

class World;

namespace detail {

/// A number for error messages: ten digits, so that small ones are not 0 and large ones are short.
TANDEM_API std::string value_text(double value);

/// "<field> must be <rule>, is <value>"; without value the text ends after the rule.
TANDEM_API std::string must_be(std::string_view field, std::string_view rule,
                               std::string_view value = {});
TANDEM_API std::string must_be(std::string_view field, std::string_view rule, double value);

/// @throws std::invalid_argument that says must_be()
[[noreturn]] TANDEM_API void refuse(std::string_view field, std::string_view rule,
                                    std::string_view value = {});
[[noreturn]] TANDEM_API void refuse(std::string_view field, std::string_view rule, double value);

/// @throws std::invalid_argument "<kind>: <field> must be <rule>, is <value>" unless `ok`
TANDEM_API void require(bool ok, std::string_view kind, std::string_view field, double value,
                        std::string_view rule);
/// @throws std::invalid_argument "<kind>: <field> must be from <low> to <high> <unit>, .." unless
///   low <= value <= high
TANDEM_API void require_in(double low, double high, std::string_view kind, std::string_view field,
                           double value, std::string_view unit = {});
/// @throws std::invalid_argument unless all components are finite
TANDEM_API void require_finite(const Vec3& value, std::string_view kind, std::string_view field);
/// @throws std::invalid_argument unless it is a quaternion of unit norm, within 1e-3
TANDEM_API void require_unit(const Quat& value, std::string_view kind, std::string_view field);
/// @throws std::invalid_argument unless it is a body of the world
TANDEM_API void require_body(const World& world, BodyId id, std::string_view kind,
                             std::string_view field);

/// Whether low <= value <= high. If not, `error`, unless null, is set to must_be().
TANDEM_API bool in_range(double value, double low, double high, std::string_view field,
                         std::string* error);

}  // namespace detail
}  // namespace tandem::pbd
