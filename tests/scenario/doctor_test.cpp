#include "sinew/diagnosis/doctor.hpp"
#include "sinew/sim/simulator.hpp"

#include <algorithm>
#include <cstdio>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

/// Every fault that doctor names, made in the simulator. A robot that is well has no finding but good ones.
namespace sinew {
namespace {

using namespace std::chrono_literals;
using diagnosis::Examination;
using diagnosis::Finding;
using diagnosis::Severity;

config::RobotFile parsed(const std::string& text)
{
    auto file = config::parse_robot_file(text, "doctor.toml");
    EXPECT_TRUE(file) << to_sentence(file.error());
    return *file;
}

/// A simulated robot, and what the robot file of its user says, which may be something else.
class Ward
{
public:
    explicit Ward(const std::string& world, const std::string& file = {})
        : world_(parsed(world)), file_(parsed(file.empty() ? world : file)), robot_(*resolve(file_)),
          simulator_(*sim::Simulator::make(world_))
    {
    }

    sim::Simulator& simulator() { return *simulator_; }
    void wait(Duration time) { simulator_->clock().wait({}, simulator_->clock().now() + time); }

    Examination examine(const std::string& bus)
    {
        diagnosis::Subject subject{.bus = bus, .link = "sim:doctor.toml#" + bus};
        for (const auto& joint : robot_.joints)
            if (joint.bus->name == bus) {
                subject.family = joint.family;
                subject.bit_rate = static_cast<std::uint32_t>(joint.bus->bit_rate->value);
                subject.expected.push_back({id_of(joint.device), joint.joint->name, joint.device});
            }
        return examine(subject);
    }

    Examination examine(const diagnosis::Subject& subject)
    {
        const auto begin = simulator_->clock().now();
        auto out =
            diagnosis::examine(subject, {.open = [&](const std::string&) -> std::expected<diagnosis::Opened, Error> {
                                   auto link = simulator_->open(subject.bus);
                                   if (!link)
                                       return std::unexpected(link.error());
                                   return diagnosis::Opened{std::move(*link), &simulator_->clock()};
                               }});
        for (const auto& f : out.findings)
            std::printf("  %-8s %-24s %s\n", std::string(to_word(f.severity)).c_str(), std::string(f.name).c_str(),
                        f.evidence.c_str());
        std::printf("  %.2f s\n", seconds(simulator_->clock().now() - begin));
        return out;
    }

private:
    config::RobotFile world_;
    config::RobotFile file_;
    ResolvedRobot robot_;
    std::unique_ptr<sim::Simulator> simulator_;
};

const Finding* find(const Examination& all, std::string_view name, std::string_view joint = {})
{
    const auto found = std::ranges::find_if(
        all.findings, [&](const Finding& f) { return f.name == name && (joint.empty() || f.joint == joint); });
    return found == all.findings.end() ? nullptr : &*found;
}

/// All that is not in order, by name.
std::vector<std::string> names(const Examination& all)
{
    std::vector<std::string> out;
    for (const auto& f : all.findings)
        if (f.severity != Severity::ok && std::ranges::find(out, f.name) == out.end())
            out.emplace_back(f.name);
    return out;
}

#define EXPECT_ONLY(all, ...)                                                                                          \
    EXPECT_EQ(names(all), (std::vector<std::string>{__VA_ARGS__})) << fmt::format("{}", fmt::join(names(all), ", "))

std::string with(std::string text, std::string_view old, std::string_view replacement)
{
    const auto at = text.find(old);
    EXPECT_NE(at, std::string::npos) << old;
    return text.replace(at, old.size(), replacement);
}

const std::string sams = R"(version = 1
name = "sams"
[bus.left]
family = "sam"
bit_rate = 1500000
[joint.one]
bus = "left"
id = 1
model = "SAM-210EO200"
[joint.two]
bus = "left"
id = 2
model = "SAM-20"
[joint.three]
bus = "left"
id = 3
model = "SAM-20"
[joint.four]
bus = "left"
id = 4
model = "SAM-28"
)";

const std::string nuris = R"(version = 1
name = "nuris"
[bus.left]
family = "nuri"
bit_rate = 115200
[joint.one]
bus = "left"
id = 1
[joint.two]
bus = "left"
id = 2
[joint.three]
bus = "left"
id = 3
)";

const std::string rmds = R"(version = 1
name = "rmds"
[bus.left]
family = "rmd"
bit_rate = 1000000
[joint.one]
bus = "left"
id = 1
model = "MG"
profile = "rmd-2.35"
[joint.two]
bus = "left"
id = 2
model = "MG"
profile = "rmd-2.35"
[joint.three]
bus = "left"
id = 3
model = "MF"
profile = "rmd-2.35"
)";

std::string fault(std::string_view kind, std::string_view joint, std::string_view more = "")
{
    return fmt::format("[[sim.fault]]\nkind = \"{}\"\njoint = \"{}\"\n{}\n", kind, joint, more);
}

TEST(Doctor, FindsNothingWrongWithTheDemoRobot)
{
    const auto file = config::read_robot_file("robots/demo.toml");
    ASSERT_TRUE(file) << to_sentence(file.error());
    const auto robot = resolve(*file);
    ASSERT_TRUE(robot);
    auto simulator = sim::Simulator::make(*file);
    ASSERT_TRUE(simulator);
    for (const auto& bus : file->buses) {
        diagnosis::Subject subject{.bus = bus.name, .link = "sim:robots/demo.toml#" + bus.name};
        for (const auto& joint : robot->joints)
            if (joint.bus == &bus) {
                subject.family = joint.family;
                subject.expected.push_back({id_of(joint.device), joint.joint->name, joint.device});
            }
        const auto all = diagnosis::examine(
            subject, {.open = [&](const std::string&) -> std::expected<diagnosis::Opened, Error> {
                return diagnosis::Opened{std::move(*(*simulator)->open(bus.name)), &(*simulator)->clock()};
            }});
        EXPECT_TRUE(all.left_out.empty());
        for (const auto& f : all.findings)
            EXPECT_EQ(f.severity, Severity::ok) << bus.name << ": " << f.name << ": " << f.evidence;
    }
}

TEST(Doctor, ChangesNothingInTheDevicesThatItLooksAt)
{
    for (const auto& text : {sams, nuris, rmds}) {
        Ward ward(text);
        const auto before = *ward.simulator().world().look("two");
        ward.examine("left");
        const auto after = *ward.simulator().world().look("two");
        EXPECT_EQ(before.position_rad, after.position_rad);
        EXPECT_EQ(before.mode, after.mode);
    }
}

TEST(Doctor, NamesADuplicateIdOfEachFamily)
{
    const auto doubled = fault("duplicate-id", "three", "id = 2\nat_s = 0.2");
    EXPECT_TRUE(find(Ward(sams + "[joint.three.sim]\nstart_rad = 1.0\n" + doubled, sams).examine("left"),
                     "duplicate-id", "two"));
    EXPECT_TRUE(find(Ward(nuris + "[joint.three.sim]\nstart_rad = 1.0\n" + doubled, nuris).examine("left"),
                     "duplicate-id", "two"));
    EXPECT_TRUE(find(Ward(rmds + "[joint.three.sim]\nstart_rad = 1.0\n" + doubled, rmds).examine("left"),
                     "duplicate-id", "two"));
}

TEST(Doctor, DoesNotTakeALossyLineForDuplicateIds)
{
    for (const auto& text : {sams, nuris}) {
        const auto all =
            Ward(text + "[[sim.fault]]\nkind = \"flip-bits\"\nbus = \"left\"\nprobability = 0.02\n").examine("left");
        EXPECT_FALSE(find(all, "duplicate-id"));
        EXPECT_TRUE(find(all, "lossy-line"));
    }
}

TEST(Doctor, NamesTheWrongBaudOfABusAndGoesOnThere)
{
    for (const auto& text : {sams, nuris}) {
        const auto all = Ward(with(text, text == sams ? "1500000" : "115200", "57600"), text).examine("left");
        EXPECT_ONLY(all, "wrong-baud");
        EXPECT_TRUE(find(all, "round-trips"));
    }
}

TEST(Doctor, NamesTheWrongBaudOfOneDevice)
{
    const auto all = Ward(sams + fault("wrong-baud", "three", "bit_rate = 115200")).examine("left");
    EXPECT_ONLY(all, "wrong-baud");
    EXPECT_TRUE(find(all, "wrong-baud", "three"));
}

TEST(Doctor, NamesAnEchoAndGoesOnWithoutIt)
{
    for (const auto& text : {sams, nuris}) {
        const auto all = Ward(text + "[bus.left.sim]\necho = true\n", text).examine("left");
        EXPECT_ONLY(all, "echo");
        EXPECT_TRUE(find(all, "round-trips"));
    }
}

TEST(Doctor, NamesAnAdapterWithALatencyOf16Ms)
{
    for (const auto& text : {sams, nuris})
        EXPECT_ONLY(Ward(text + "[bus.left.sim]\nusb_latency_s = 0.016\n", text).examine("left"), "slow-adapter");
}

TEST(Doctor, SaysWhereTheChainIsBroken)
{
    for (const auto& text : {sams, nuris, rmds}) {
        const auto cut = text == sams ? fault("unplug", "three") + fault("unplug", "four") : fault("unplug", "three");
        const auto all = Ward(text + cut, text).examine("left");
        EXPECT_ONLY(all, "broken-chain");
        EXPECT_NE(find(all, "broken-chain")->next.find("from id 2 (two) to id 3 (three)"), std::string::npos);
    }
}

TEST(Doctor, NamesASilentResponseLevelOfASamWhoseNeighboursAnswer)
{
    const auto all = Ward(sams + "[joint.two.sim]\nresponse_level = 2\n", sams).examine("left");
    EXPECT_ONLY(all, "missing-device", "silent-response-level");
    EXPECT_TRUE(find(all, "silent-response-level", "two"));
}

TEST(Doctor, SaysThatTheRobotFileItselfHasASilentSam)
{
    EXPECT_ONLY(Ward(sams + "[joint.two.profile_options]\nresponse_level = 2\n").examine("left"),
                "silent-response-level");
}

TEST(Doctor, NamesAResponseLevelThatDiffers)
{
    EXPECT_ONLY(Ward(sams + "[joint.two.sim]\nresponse_level = 1\n", sams).examine("left"), "response-level-differs");
}

TEST(Doctor, NamesNobodyAtAll)
{
    for (const auto& text : {sams, nuris, rmds}) {
        const auto all = Ward(text + "[[sim.fault]]\nkind = \"power-cut\"\nbus = \"left\"\n", text).examine("left");
        EXPECT_ONLY(all, "no-answer");
    }
}

TEST(Doctor, NamesLowVoltage)
{
    const std::string brown_out = "[[sim.fault]]\nkind = \"brown-out\"\nbus = \"left\"\nvoltage_v = 6.5\n";
    EXPECT_TRUE(find(Ward(sams + brown_out, sams).examine("left"), "low-voltage", "one"));
    EXPECT_TRUE(find(Ward(rmds + brown_out, rmds).examine("left"), "low-voltage", "one"));
}

TEST(Doctor, TellsALatchedOverTemperatureFromOneThatLasts)
{
    Ward ward(rmds + fault("hot-motor", "two", "temperature_c = 120"), rmds);
    ward.wait(100ms);
    EXPECT_ONLY(ward.examine("left"), "over-temperature");
    sim::Fault cool{.kind = sim::FaultKind::hot_motor, .joint = "two", .temperature_c = 30.0};
    ward.simulator().world().mend("two");
    ward.simulator().world().inject(cool);
    ward.wait(100ms);
    EXPECT_ONLY(ward.examine("left"), "latched-over-temperature");
}

TEST(Doctor, NamesAHotSam)
{
    Ward ward(sams + fault("hot-motor", "two", "temperature_c = 90"), sams);
    ward.wait(100ms);
    EXPECT_TRUE(find(ward.examine("left"), "over-temperature", "two"));
}

TEST(Doctor, NamesASamOfAnotherModel)
{
    const auto all = Ward(sams, with(sams, "SAM-28", "SAM-5")).examine("left");
    EXPECT_TRUE(find(all, "wrong-model", "four"));
    EXPECT_FALSE(find(all, "duplicate-id"));
}

TEST(Doctor, NamesAnRmdOfAnotherFirmwareLineWhoseSpeedsCountAHundredTimesMore)
{
    const auto all = Ward(with(rmds, "profile = \"rmd-2.35\"", "profile = \"lk-2.35\""), rmds).examine("left");
    EXPECT_ONLY(all, "wrong-profile");
    EXPECT_TRUE(find(all, "wrong-profile", "one"));
}

TEST(Doctor, NamesAnRmdThatAnswersOnOtherIdentifiers)
{
    const auto all = Ward(with(rmds, "profile = \"rmd-2.35\"", "profile = \"lk-2.36\""), rmds).examine("left");
    EXPECT_ONLY(all, "wrong-profile");
}

TEST(Doctor, NamesAScaleThatIsNotThatOfItsLine)
{
    EXPECT_ONLY(Ward(rmds + "[joint.two.profile_options]\nmax_speed_lsb_dps = 1\n").examine("left"), "wrong-scale");
}

TEST(Doctor, NamesAGearOfANuriThatTheRobotFileDoesNotKnow)
{
    const std::string geared = nuris + "[joint.two.profile_options]\nexternal_gear_ratio = 2.5\n";
    for (const auto& [world, file] : {std::pair{geared, nuris}, {nuris, geared}}) {
        const auto all = Ward(world, file).examine("left");
        EXPECT_ONLY(all, "wrong-scale");
        const auto* wrong = find(all, "wrong-scale", "two");
        ASSERT_TRUE(wrong);
        EXPECT_EQ(wrong->next, fmt::format("Write external_gear_ratio = {} under profile_options of the joint.",
                                           world == geared ? "2.5" : "1"));
    }
    EXPECT_ONLY(Ward(geared).examine("left"));
}

TEST(Doctor, NamesANuriThatAnswersLaterThanTheRobotFileSays)
{
    const std::string late = nuris + "[joint.three.profile_options]\nresponse_time_us = 5000\n";
    const auto all = Ward(late, nuris).examine("left");
    EXPECT_ONLY(all, "response-time-differs");
    const auto* differs = find(all, "response-time-differs", "three");
    ASSERT_TRUE(differs);
    EXPECT_EQ(differs->next, "Write response_time_us = 5000 under profile_options of the joint.");
    EXPECT_ONLY(Ward(nuris, late).examine("left"));
}

TEST(Doctor, NotesAScaleThatNobodyConfirmed)
{
    EXPECT_ONLY(Ward(with(rmds, "profile = \"rmd-2.35\"\n", "")).examine("left"), "unconfirmed-scale");
}

TEST(Doctor, NamesAnotherFamily)
{
    EXPECT_TRUE(find(Ward(nuris, sams).examine("left"), "wrong-family"));
}

TEST(Doctor, NamesABusyPort)
{
    Ward ward(sams);
    const auto held = ward.simulator().open("left");
    ASSERT_TRUE(held);
    const auto all = ward.examine("left");
    EXPECT_ONLY(all, "port-busy");
    EXPECT_FALSE(all.left_out.empty());
}

TEST(Doctor, LooksAtALinkWithoutARobotFile)
{
    Ward ward(nuris);
    const auto all = ward.examine(diagnosis::Subject{.bus = "left", .link = "sim:doctor.toml"});
    EXPECT_ONLY(all);
    EXPECT_TRUE(find(all, "round-trips"));
}

TEST(Doctor, NotesADeviceThatTheRobotFileDoesNotKnow)
{
    EXPECT_ONLY(Ward(sams + "[joint.five]\nbus = \"left\"\nid = 77\nmodel = \"SAM-5\"\n", sams).examine("left"),
                "unexpected-device");
}

TEST(Kinds, BelongToChecksThatAreMadeAndHaveSomethingToSay)
{
    const auto all = diagnosis::checks();
    for (const auto& kind : diagnosis::kinds()) {
        EXPECT_TRUE(std::ranges::any_of(all, [&](const auto& check) { return check.name == kind.check; })) << kind.name;
        EXPECT_TRUE(kind.meaning.ends_with(".")) << kind.name;
        EXPECT_FALSE(kind.next.empty()) << kind.name;
        EXPECT_NE(kind.severity, Severity::ok) << kind.name;
    }
}

} // namespace
} // namespace sinew
