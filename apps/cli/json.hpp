#pragma once
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace sinew::cli {

/// A value to build and print; keys keep their order. Numbers that are not finite become null.
class Json
{
public:
    Json(); ///< null
    Json(bool value);
    Json(int value);
    Json(std::int64_t value);
    Json(std::uint32_t value);
    Json(double value);
    Json(const char* value);
    Json(std::string_view value);
    Json(const std::string& value);
    template <class T>
    Json(const std::optional<T>& value) : Json(value ? Json(*value) : Json())
    {
    }
    ~Json();
    Json(const Json& other);
    Json(Json&& other) noexcept;
    Json& operator=(Json other) noexcept;

    static Json object(std::initializer_list<std::pair<std::string_view, Json>> members = {});
    static Json array(std::initializer_list<Json> elements = {});

    /// Adds to an object; to an array.
    void set(std::string_view key, Json value);
    void add(Json value);

    /// One line, or indented for people.
    std::string line() const;
    std::string pretty() const;

private:
    struct Tree;
    std::unique_ptr<Tree> tree_;
};

/// Prints to stdout, indented.
void print(const Json& value);
/// One line, written at once, for streams of objects.
void print_line(const Json& value);

} // namespace sinew::cli
