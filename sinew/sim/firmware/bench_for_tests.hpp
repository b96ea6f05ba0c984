#pragma once
#include "sinew/sim/firmware/device.hpp"
#include "sinew/sim/firmware/ratings.hpp"
#include "sinew/wire/codec.hpp"
#include "sinew/wire/values.hpp"

#include <gtest/gtest.h>

#include <optional>

namespace sinew::sim {

/// The loop of `Servo` leaves a shaft within 2e-5 rad of its target; friction may hold it a little further off.
inline constexpr double rest_rad = 5e-5;
inline constexpr double rest_deg = rest_rad * 180.0 / 3.14159;
/// How long the last of the way takes beyond the time of the trajectory.
inline constexpr int settle_ms = 60;

/// One device on a bench, without a wire: requests are heard when they are sent.
template <class D>
class Bench
{
public:
    template <class Spec>
    explicit Bench(const Spec& spec) : Bench(spec, plant_of(spec))
    {
    }
    template <class Spec>
    Bench(const Spec& spec, const PlantParameters& plant)
        : device(spec, plant), supply_v_(supply_v(spec)), options_(spec.profile.options())
    {
        device.run(supply_v_);
    }

    /// Whole ticks of it.
    void run(Duration time)
    {
        for (const TimePoint until = now + time; now + tick <= until; now += tick)
            device.run(supply_v_);
    }
    void supply(double voltage_v) { supply_v_ = voltage_v; }

    template <class M>
    std::optional<Answer> send(int id, const M& message)
    {
        const auto frame = wire::encode_request(id, message, options_);
        EXPECT_TRUE(frame) << wire::info_of<M>.name();
        return frame ? device.hear(*frame, now) : std::nullopt;
    }
    template <class M>
    std::optional<Answer> send(const M& message)
    {
        return send(device.id(), message);
    }

    /// The reply; the device must give one.
    template <class M>
    wire::ReplyOf<M> ask(const M& message)
    {
        const auto answer = send(message);
        EXPECT_TRUE(answer) << wire::info_of<M>.name();
        if (!answer)
            return {};
        const auto reply = wire::decode_reply<M>(answer->frame, options_);
        EXPECT_TRUE(reply) << wire::info_of<M>.name();
        return reply ? reply->message : wire::ReplyOf<M>{};
    }

    D device;
    TimePoint now{};

private:
    double supply_v_;
    wire::Options options_;
};

/// Values inside every range that make sense together.
inline wire::Values sample_values(const wire::MessageInfo& message, wire::Options options)
{
    constexpr std::int64_t max_speed_parameter = 0x9A;
    wire::Values out;
    for (const wire::Value& value : wire::value_fields(message.request, options, max_speed_parameter)) {
        const wire::Field& field = *value.field;
        const wire::Range range = wire::allowed(field);
        std::int64_t raw = range.low + (range.high - range.low) / 3;
        if (field.name == "upper_boundary")
            raw = range.high;
        else if (field.name == "new_id")
            raw = 7;
        else if (field.name == "motion_count")
            raw = 0;
        else if (field.name == "param_id")
            raw = max_speed_parameter;
        if (field.kind != wire::Kind::sequence)
            out.add(field, raw);
    }
    return out;
}

} // namespace sinew::sim
