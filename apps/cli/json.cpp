#include "apps/cli/json.hpp"

#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace sinew::cli {
namespace {

std::string dump(const nlohmann::ordered_json& value, int indent)
{
    // Words from a command line need not be UTF-8.
    return value.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

} // namespace

struct Json::Tree {
    nlohmann::ordered_json value;
};

Json::Json() : tree_(std::make_unique<Tree>()) {}
Json::Json(bool value) : tree_(new Tree{value}) {}
Json::Json(int value) : tree_(new Tree{value}) {}
Json::Json(std::int64_t value) : tree_(new Tree{value}) {}
Json::Json(std::uint32_t value) : tree_(new Tree{value}) {}
Json::Json(double value) : tree_(new Tree{std::isfinite(value) ? nlohmann::ordered_json(value) : nullptr}) {}
Json::Json(const char* value) : Json(std::string_view(value)) {}
Json::Json(std::string_view value) : tree_(new Tree{std::string(value)}) {}
Json::Json(const std::string& value) : Json(std::string_view(value)) {}
Json::~Json() = default;
Json::Json(const Json& other) : tree_(new Tree{other.tree_->value}) {}
Json::Json(Json&& other) noexcept = default;

Json& Json::operator=(Json other) noexcept
{
    tree_.swap(other.tree_);
    return *this;
}

Json Json::object(std::initializer_list<std::pair<std::string_view, Json>> members)
{
    Json out;
    out.tree_->value = nlohmann::ordered_json::object();
    for (const auto& [key, value] : members)
        out.set(key, value);
    return out;
}

Json Json::array(std::initializer_list<Json> elements)
{
    Json out;
    out.tree_->value = nlohmann::ordered_json::array();
    for (const auto& element : elements)
        out.add(element);
    return out;
}

void Json::set(std::string_view key, Json value)
{
    tree_->value[std::string(key)] = std::move(value.tree_->value);
}

void Json::add(Json value)
{
    tree_->value.push_back(std::move(value.tree_->value));
}

std::string Json::line() const
{
    return dump(tree_->value, -1);
}
std::string Json::pretty() const
{
    return dump(tree_->value, 2);
}

void print(const Json& value)
{
    fmt::print("{}\n", value.pretty());
}

void print_line(const Json& value)
{
    fmt::print("{}\n", value.line());
    std::fflush(stdout);
}

} // namespace sinew::cli
