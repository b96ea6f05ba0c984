#pragma once
#include "sinew/wire/protocol.hpp"

#include <expected>
#include <span>
#include <string_view>

/// The three families as the manuals have them, for tests that treat them alike.
namespace sinew::test {

/// Decodes a frame with the typed codec of one message and encodes what came out.
using Again = std::expected<wire::Frame, Error> (*)(const wire::Frame&, wire::Options);

struct TypedCodec {
    const wire::MessageInfo* message = nullptr;
    wire::Direction direction{};
    Again again = nullptr;
};

struct Family {
    std::string_view name;
    wire::Profile manual; ///< every message of the manual, every option as recommended
    const wire::Protocol* protocol = nullptr;
    std::span<const TypedCodec> typed;

    Again again(const wire::MessageInfo& message, wire::Direction direction) const;
};

std::span<const Family> families();
const Family& family(std::string_view name);

} // namespace sinew::test
