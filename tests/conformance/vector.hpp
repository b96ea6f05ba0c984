#pragma once
#include "sinew/wire/values.hpp"
#include "tests/support/families.hpp"

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

/// The examples of the manuals, and what they are meant to say.
namespace sinew::conformance {

using nlohmann::json;

struct Vector {
    std::string id;
    const test::Family* family = nullptr;
    wire::Direction direction{};
    bool erratum = false;
    wire::Options options{};
    json all; ///< the whole entry
};

/// What an example says, in the words of a row.
struct Meant {
    const wire::MessageInfo* message = nullptr;
    int id = -1;
    wire::Values values;
    std::vector<std::pair<const wire::Field*, std::int64_t>> repeats; ///< repeated bytes that the example names
};

/// A file of tests/conformance/data.
json read_data(const std::string& name);

std::vector<Vector> read_vectors(const std::string& name);

/// "set_id" → "set-id".
std::string with_dashes(std::string name);

/// The frame of some bytes; the identifier is that of the example, or of id 1 where none is printed.
wire::Frame to_frame(const Vector& vector, const json& bytes);

/// One reading per row that the example can belong to (a Nuri reply belongs to its own and to that of its request).
/// Throws std::runtime_error where the example says something that no row has, or leaves a value open.
std::vector<Meant> to_meant(const Vector& vector, const json& meaning, wire::Options options);

} // namespace sinew::conformance
