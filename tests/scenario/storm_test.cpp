#include "sinew/sim/world.hpp"
#include "sinew/wire/values.hpp"
#include "tests/support/random.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>

/// Random requests and random faults for a long time of the simulated world. Whatever happens: no NaN, no energy from
/// nothing, no shaft beyond a hard stop, no flash that changes but by a write. SINEW_SIM_MINUTES is how long,
/// SINEW_SEED makes a run again.
namespace sinew::sim {
namespace {

using namespace std::chrono_literals;
using test::Random;

config::RobotFile stormy_robot()
{
    auto file = *config::read_robot_file("robots/demo.toml");
    for (config::Joint& joint : file.joints) {
        joint.plant.push_back({"stop_min_rad", -3.5, {}});
        joint.plant.push_back({"stop_max_rad", 3.5, {}});
        joint.plant.push_back({"gravity_torque_nm", 0.1, {}});
        joint.plant.push_back({"load_inertia_kg_m2", 0.01, {}});
    }
    return file;
}

/// A host that reads everything and believes nothing.
struct SerialEar final : SerialHost {
    std::uint32_t bit_rate() const override { return rate; }
    void on_bytes(std::span<const std::uint8_t> bytes, TimePoint) override { heard += bytes.size(); }
    std::uint32_t rate = 0;
    std::size_t heard = 0;
};
struct CanEar final : CanHost {
    std::uint32_t bit_rate() const override { return rate; }
    void on_frame(const wire::Frame&, TimePoint) override { ++heard; }
    std::uint32_t rate = 0;
    std::size_t heard = 0;
};

class Storm
{
public:
    explicit Storm(std::string_view name) : random_(name), file_(stormy_robot()), robot_(*resolve(file_))
    {
        auto world = World::make(file_);
        EXPECT_TRUE(world) << to_sentence(world.error());
        world_ = std::move(*world);
        for (WorldBus& bus : world_->buses()) {
            if (auto* serial = std::get_if<SerialWire>(&bus.wire)) {
                SerialEar& ear = serial_ears_[bus.name];
                ear.rate = bus.bit_rate;
                serial->connect(&ear);
            } else {
                CanEar& ear = can_ears_[bus.name];
                ear.rate = bus.bit_rate;
                std::get<CanWire>(bus.wire).connect(&ear);
            }
        }
    }

    /// One tick: some requests, now and then a fault, and a look at every shaft.
    void tick_once()
    {
        if (random_.one_in(4))
            send();
        if (random_.one_in(2000))
            disturb();
        remember();
        world_->advance(world_->now() + tick);
        check();
        check_flash();
    }

    /// What all devices keep, given to another world of the same robot, is there again.
    void check_flash_file()
    {
        const std::string flash = world_->flash();
        const auto file = config::parse_flash_file(flash, "storm");
        ASSERT_TRUE(file) << to_sentence(file.error());
        const auto other = World::make(file_);
        ASSERT_TRUE(other);
        const auto restored = (*other)->restore(*file);
        ASSERT_TRUE(restored) << to_sentence(restored.error());
        ASSERT_EQ((*other)->flash(), flash);
    }

    /// Who is off already lost its supply within the few seconds that a fault lasts.
    void cut_the_power()
    {
        const ResolvedJoint& joint = robot_.joints[random_.below(robot_.joints.size())];
        Fault fault{.kind = FaultKind::power_cut, .for_s = 0.5};
        fault.joint = joint.joint->name;
        world_->inject(fault);
        ++disturbed;
    }

    std::size_t heard() const
    {
        std::size_t all = 0;
        for (const auto& [name, ear] : serial_ears_)
            all += ear.heard;
        for (const auto& [name, ear] : can_ears_)
            all += ear.heard;
        return all;
    }
    std::size_t sent = 0, disturbed = 0, power_losses = 0;

private:
    struct Before {
        double velocity_rad_s = 0.0, position_rad = 0.0, external_nm = 0.0;
    };

    WorldBus& bus_of(const ResolvedJoint& joint) { return **world_->find_bus(joint.bus->name); }

    wire::Frame request(const ResolvedJoint& joint)
    {
        const auto messages = line_of(joint.device).messages;
        for (;;) {
            const wire::MessageInfo& message = *messages[random_.below(messages.size())];
            // Who once has another id or rate would not be heard of again.
            const bool moves_away = message.name().find("set-id") != std::string_view::npos ||
                                    message.name().find("baud") != std::string_view::npos ||
                                    message.name().find("factory") != std::string_view::npos;
            if (!message.request.exists() || moves_away)
                continue;
            wire::Values values;
            const auto options = options_of(joint.device);
            const std::int64_t selector = 0x96 + static_cast<std::int64_t>(random_.below(9));
            for (const wire::Value& value : wire::value_fields(message.request, options, selector)) {
                const wire::Field& field = *value.field;
                if (field.kind != wire::Kind::sequence)
                    values.add(field, field.name == "motion_count" ? 0
                                      : field.name == "param_id"   ? selector
                                                                   : random_.in(wire::allowed(field)));
            }
            const auto frame = wire::encode(message, wire::Direction::request, id_of(joint.device), values, options);
            if (frame)
                return *frame;
        }
    }

    void send()
    {
        const ResolvedJoint& joint = robot_.joints[random_.below(robot_.joints.size())];
        wire::Frame frame = request(joint);
        if (random_.one_in(20))
            frame.data[random_.below(frame.size)] ^= random_.byte();
        WorldBus& bus = bus_of(joint);
        if (auto* serial = std::get_if<SerialWire>(&bus.wire))
            serial->host_sends(frame.bytes(), bus.bit_rate, world_->now());
        else
            std::get<CanWire>(bus.wire).host_sends(frame, bus.bit_rate, world_->now());
        ++sent;
    }

    void disturb()
    {
        const auto kinds = fault_kinds();
        const FaultKindInfo& kind = kinds[random_.below(kinds.size())];
        Fault fault{.kind = kind.kind, .for_s = 0.001 * static_cast<double>(1 + random_.below(3000))};
        const ResolvedJoint& joint = robot_.joints[random_.below(robot_.joints.size())];
        if (kind.hits_bus && (!kind.hits_joint || random_.one_in(2)))
            fault.bus = joint.bus->name;
        else
            fault.joint = joint.joint->name;
        fault.probability = 0.001 * static_cast<double>(random_.below(200));
        fault.voltage_v = static_cast<double>(random_.below(24));
        fault.temperature_c = static_cast<double>(random_.below(150));
        fault.torque_nm = static_cast<double>(random_.below(20)) - 10.0;
        fault.id = 1 + static_cast<std::int64_t>(random_.below(6));
        world_->inject(fault);
        ++disturbed;
    }

    void remember()
    {
        before_.clear();
        for (const auto joint : world_->joints()) {
            const Plant& plant = world_->find_device(joint)->plant();
            before_.push_back({plant.velocity_rad_s(), plant.position_rad(), plant.external_nm()});
        }
    }

    void check()
    {
        for (std::size_t i = 0; i < before_.size(); ++i) {
            const auto joint = world_->joints()[i];
            const Device& device = *world_->find_device(joint);
            const Plant& plant = device.plant();
            const PlantParameters& p = plant.parameters();
            const double v = plant.velocity_rad_s();
            const double x = plant.position_rad();
            ASSERT_TRUE(std::isfinite(v) && std::isfinite(x) && std::isfinite(plant.current_a()) &&
                        std::isfinite(plant.winding_c()) && std::isfinite(device.look().voltage_v))
                << joint;
            ASSERT_GE(x, p.stop_min_rad) << joint;
            ASSERT_LE(x, p.stop_max_rad) << joint;
            // What motion and height gained, somebody paid: the supply less copper heat, or the push from outside. The
            // square of the mean current is at most the mean of its square, and a fault changes the push within a tick.
            const auto energy = [&](double speed, double position) {
                return 0.5 * p.inertia_kg_m2() * speed * speed +
                       p.gravity_torque_nm * (1.0 - std::cos(position - p.gravity_zero_rad));
            };
            const double gained = energy(v, x) - energy(before_[i].velocity_rad_s, before_[i].position_rad);
            const double electric_w = device.look().voltage_v * plant.supply_current_a() -
                                      plant.current_a() * plant.current_a() * p.winding_ohm;
            const double turned = x - before_[i].position_rad;
            const double pushed = std::max(before_[i].external_nm * turned, plant.external_nm() * turned);
            const double paid = electric_w * tick_s + pushed;
            ASSERT_LE(gained, paid + 1e-4 + 0.02 * std::abs(paid)) << joint << " from nothing";
        }
    }

    // A flash is what it was at its last write, through every loss of power and back.
    void check_flash()
    {
        for (const auto joint : world_->joints()) {
            const Device& device = *world_->find_device(joint);
            Flash& flash = flashes_[joint];
            const bool written = device.flash_writes() != flash.writes;
            const bool turned = device.is_on() != flash.was_on;
            power_losses += turned && flash.was_on;
            flash.was_on = device.is_on();
            if (!written && !turned)
                continue;
            std::vector<std::int64_t> values;
            for (const KeptValue& kept : device.kept())
                values.push_back(kept.value);
            if (!written && !flash.values.empty()) {
                ASSERT_EQ(values, flash.values) << joint << ": its flash changed without a write";
            }
            flash.writes = device.flash_writes();
            flash.values = std::move(values);
        }
    }

    struct Flash {
        std::vector<std::int64_t> values;
        std::uint32_t writes = 0;
        bool was_on = false;
    };

    Random random_;
    config::RobotFile file_;
    ResolvedRobot robot_;
    std::unique_ptr<World> world_;
    std::map<std::string, SerialEar> serial_ears_;
    std::map<std::string, CanEar> can_ears_;
    std::vector<Before> before_;
    std::map<std::string_view, Flash> flashes_;
};

TEST(Storm, RandomRequestsAndFaultsBreakNothing)
{
    const std::uint64_t minutes = test::setting("SINEW_SIM_MINUTES", 1);
    Storm storm("storm");
    for (std::uint64_t i = 0; i < minutes * 60'000; ++i) {
        storm.tick_once();
        if (i % 60'000 == 30'000)
            storm.check_flash_file();
        if (i % 60'000 == 45'000)
            storm.cut_the_power();
        if (HasFatalFailure())
            FAIL() << "at " << i << " ms of SINEW_SEED=" << test::seed();
    }
    EXPECT_GT(storm.heard(), storm.sent / 10) << "the devices have fallen silent";
    EXPECT_GE(storm.power_losses, minutes) << "no storm";
    std::printf("storm: seed %llu, %llu simulated minutes, %zu requests, %zu faults, %zu losses of power, "
                "%zu bytes and frames heard\n",
                static_cast<unsigned long long>(test::seed()), static_cast<unsigned long long>(minutes), storm.sent,
                storm.disturbed, storm.power_losses, storm.heard());
}

} // namespace
} // namespace sinew::sim
