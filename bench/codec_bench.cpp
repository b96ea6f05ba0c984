#include "bench/codec_bench.hpp"

#include "bench/reference.hpp"
#include "tests/support/allocations.hpp"

#include <algorithm>
#include <array>
#include <chrono>

namespace sinew::bench {
namespace {

using wire::Frame;

constexpr std::size_t inputs = 256; // enough that no branch is learnt by heart, few enough to stay in the cache
constexpr std::size_t sweeps = 800; // of all inputs, per round
constexpr std::size_t rounds = 40;  // the fastest counts: everything else is the machine doing something else

/// Makes the compiler believe that the value is used.
template <class T>
[[gnu::always_inline]] inline void use(const T& value)
{
    asm volatile("" : : "r"(&value) : "memory");
}

// The codec is called as the rest of the library calls it: through a function that is not inlined.
[[gnu::noinline]] auto encode_sam(int id, const sam::PositionControl& m)
{
    return wire::encode_request(id, m);
}
[[gnu::noinline]] auto encode_nuri(int id, const nuri::PositionSpeedControl& m)
{
    return wire::encode_request(id, m);
}
[[gnu::noinline]] auto encode_rmd(int id, const rmd::MultiLoopAngleSpeed& m)
{
    return wire::encode_request(id, m);
}
[[gnu::noinline]] auto decode_sam(const Frame& frame)
{
    return wire::decode_request<sam::PositionControl>(frame);
}
[[gnu::noinline]] auto decode_nuri(const Frame& frame)
{
    return wire::decode_reply<nuri::RequestPositionFeedback>(frame);
}
[[gnu::noinline]] auto decode_rmd(const Frame& frame)
{
    return wire::decode_reply<rmd::ReadStatus2>(frame);
}

/// The time of one round in ns per operation.
template <class Input, class Operation>
double round_ns(const std::array<Input, inputs>& all, Operation operation)
{
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t sweep = 0; sweep < sweeps; ++sweep)
        for (const auto& input : all) {
            const auto out = operation(input);
            use(out);
        }
    const std::chrono::duration<double, std::nano> elapsed = std::chrono::steady_clock::now() - start;
    return elapsed.count() / static_cast<double>(sweeps * inputs);
}

template <class Input, class Ours, class Theirs>
Result measure(std::string family, std::string operation, std::string_view message,
               const std::array<Input, inputs>& all, Ours ours, Theirs theirs)
{
    Result out{.family = std::move(family), .operation = std::move(operation), .message = std::string(message)};
    out.ns = out.reference_ns = out.reference_again_ns = 1e9;
    for (std::size_t round = 0; round < rounds; ++round) {
        const auto before = support::allocations();
        out.ns = std::min(out.ns, round_ns(all, ours));
        out.allocations +=
            static_cast<double>(support::allocations() - before) / static_cast<double>(rounds * sweeps * inputs);
        out.reference_ns = std::min(out.reference_ns, round_ns(all, theirs));
        out.reference_again_ns = std::min(out.reference_again_ns, round_ns(all, theirs));
    }
    return out;
}

template <class M>
struct Outgoing {
    int id = 0;
    M message{};
};

template <class Make>
auto make_inputs(Make make)
{
    std::array<decltype(make(0)), inputs> out{};
    for (std::size_t i = 0; i < inputs; ++i)
        out[i] = make(static_cast<int>(i));
    return out;
}

void measure_sam(std::vector<Result>& out)
{
    const auto requests = make_inputs(
        [](int i) { return Outgoing<sam::PositionControl>{i % 255, {static_cast<std::uint16_t>(i * 127)}}; });
    out.push_back(measure(
        "sam", "encode", wire::info_of<sam::PositionControl>.name(), requests,
        [](const auto& in) { return encode_sam(in.id, in.message); },
        [](const auto& in) { return reference::encode_sam(in.id, in.message); }));
    const auto frames = make_inputs([&](int i) { return *encode_sam(requests[i].id, requests[i].message); });
    out.push_back(measure("sam", "decode", wire::info_of<sam::PositionControl>.name(), frames, decode_sam,
                          reference::decode_sam));
}

void measure_nuri(std::vector<Result>& out)
{
    const auto requests = make_inputs([](int i) {
        return Outgoing<nuri::PositionSpeedControl>{
            i,
            {i % 2 == 0 ? nuri::Rotation::clockwise : nuri::Rotation::counter_clockwise,
             static_cast<std::uint16_t>(i * 255), static_cast<std::uint16_t>(1 + i * 3)}};
    });
    out.push_back(measure(
        "nuri", "encode", wire::info_of<nuri::PositionSpeedControl>.name(), requests,
        [](const auto& in) { return encode_nuri(in.id, in.message); },
        [](const auto& in) { return reference::encode_nuri(in.id, in.message); }));
    const auto frames = make_inputs([](int i) {
        return *wire::encode_reply<nuri::RequestPositionFeedback>(
            i % 255, {nuri::Rotation::clockwise, static_cast<std::uint16_t>(i * 255), static_cast<std::uint16_t>(i * 3),
                      static_cast<std::uint8_t>(i % 255)});
    });
    out.push_back(measure("nuri", "decode", wire::info_of<nuri::ReplyPositionFeedback>.name(), frames, decode_nuri,
                          reference::decode_nuri));
}

void measure_rmd(std::vector<Result>& out)
{
    const auto requests = make_inputs([](int i) {
        return Outgoing<rmd::MultiLoopAngleSpeed>{1 + i % 32, {static_cast<std::uint16_t>(i * 7), (i - 128) * 100'003}};
    });
    out.push_back(measure(
        "rmd", "encode", wire::info_of<rmd::MultiLoopAngleSpeed>.name(), requests,
        [](const auto& in) { return encode_rmd(in.id, in.message); },
        [](const auto& in) { return reference::encode_rmd(in.id, in.message); }));
    const auto frames = make_inputs([](int i) {
        return *wire::encode_reply<rmd::ReadStatus2>(
            1 + i % 32, {static_cast<std::int8_t>(i - 128), static_cast<std::int16_t>((i - 128) * 16),
                         static_cast<std::int16_t>((i - 128) * 200), static_cast<std::uint16_t>(i * 250)});
    });
    out.push_back(
        measure("rmd", "decode", wire::info_of<rmd::ReadStatus2>.name(), frames, decode_rmd, reference::decode_rmd));
}

} // namespace

std::vector<Result> measure_codecs()
{
    std::vector<Result> out;
    measure_sam(out);
    measure_nuri(out);
    measure_rmd(out);
    return out;
}

} // namespace sinew::bench
