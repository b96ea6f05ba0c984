#pragma once
#include "apps/cli/decoder.hpp"

#include <deque>
#include <functional>
#include <map>

/// Makes a conversation out of what was captured: whole frames, who said them, and which request an answer belongs to.
namespace sinew::cli {

/// A frame, or what is none, with its place in the conversation.
struct Heard {
    /// How it is known who said it.
    enum class Side : std::uint8_t {
        unknown,
        capture, ///< whoever captured it knew
        frame,   ///< only one of the two says this
        order,   ///< it follows a request that it can answer, or does not; a lost answer can deceive
    };

    record::Time at{};
    std::string bus;
    record::Captured::Kind kind{};
    Side side = Side::unknown;
    std::optional<wire::Direction> direction;
    Decoded decoded; ///< with one reading at most; family nullptr: nobody knows whose bytes these are
    std::string discarded;

    bool is_error() const { return decoded.error.has_value() || !discarded.empty(); }
};

/// Of any number of buses. On serial lines the two directions may be two wires or one: then a bare answer is what
/// follows a request that has one, unless it is a request itself.
class Listener
{
public:
    using Use = std::function<void(const Heard&)>;
    /// Longer than a frame may pause, and adapters hold bytes back.
    static constexpr Duration silence = std::chrono::milliseconds(50);
    /// The latest that an answer on CAN may follow its request, where nothing but the order tells them apart.
    static constexpr Duration answer_most = std::chrono::milliseconds(10);

    /// `devices` are read with their own scales. Fails where the options cannot be right.
    static std::expected<Listener, Error> make(DecodeOptions options, std::vector<Device> devices);

    void hear(const record::Captured& captured, const Use& use);
    /// All lines have been silent: what waits for the rest of a frame is none.
    void fall_silent(const Use& use);

private:
    struct Request {
        const wire::MessageInfo* message = nullptr;
        int id = -1;
    };
    struct Line {
        std::vector<std::uint8_t> from_host; ///< and of both, where nobody knows
        std::vector<std::uint8_t> from_devices;
        record::Time last{};
        Request asked;                                                         ///< whose bare answer is due
        std::map<std::pair<std::uint32_t, std::uint8_t>, record::Time> on_can; ///< unanswered, by identifier and opcode
        const Family* family = nullptr;
    };

    explicit Listener(DecodeOptions options) : options_(std::move(options)) {}
    const Device& device(const Family& family, int id) const;
    void hear_can(Line& line, const record::Captured& captured, Heard& heard, const Use& use);
    void hear_bytes(Line& line, const record::Captured& captured, Heard& heard, const Use& use);
    void take_requests(Line& line, std::vector<std::uint8_t>& bytes, bool mixed, bool silent, Heard& heard,
                       const Use& use);
    bool take_bare_reply(Line& line, std::vector<std::uint8_t>& bytes, bool mixed, bool silent, Heard& heard,
                         const Use& use);
    void take_replies(Line& line, bool silent, Heard& heard, const Use& use);
    void flush(const std::string& bus, Line& line, const Use& use);
    void frame(Line& line, std::span<const std::uint8_t> bytes, Heard& heard, const Use& use);
    void garbage(const Line& line, std::span<const std::uint8_t> bytes, Heard& heard, const Use& use);

    DecodeOptions options_;
    std::vector<Device> devices_;
    std::map<const Family*, Device> readers_; ///< for ids that no device has
    std::map<std::string, Line> lines_;
};

} // namespace sinew::cli
