#include "sinew/family/families.hpp"

#include "sinew/family/assumed.hpp"
#include "sinew/family/nuri/messages.hpp"
#include "sinew/family/sam/messages.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <set>

namespace sinew {
namespace {

std::string complaint(const std::string& joints)
{
    const auto file = config::parse_robot_file("version = 1\n[bus.s]\nfamily = \"sam\"\n[bus.n]\nfamily = \"nuri\"\n"
                                               "[bus.r]\nfamily = \"rmd\"\n" +
                                                   joints, // its first line is 8
                                               "r.toml");
    if (!file)
        return "not parsed: " + file.error().detail;
    const auto robot = resolve(*file);
    if (robot)
        return "nothing";
    EXPECT_EQ(robot.error().code, Errc::bad_file);
    return robot.error().detail;
}

DeviceSpec only_device(const std::string& joint)
{
    const auto file = config::parse_robot_file("version = 1\n[bus.s]\nfamily = \"sam\"\nbit_rate = 115200\n[bus.n]\n"
                                               "family = \"nuri\"\n[bus.r]\nfamily = \"rmd\"\n" +
                                                   joint,
                                               "r.toml");
    EXPECT_TRUE(file) << to_sentence(file.error());
    const auto robot = resolve(*file);
    EXPECT_TRUE(robot) << to_sentence(robot.error());
    return robot->joints.front().device;
}

TEST(Families, AreFoundByNameAndTellWhatAHostMustKnow)
{
    ASSERT_EQ(families().size(), 3U);
    const Family& sam = *find_family("sam");
    EXPECT_FALSE(sam.can);
    EXPECT_EQ(sam.default_bit_rate, 1'500'000U);
    EXPECT_EQ(sam.bit_rates.size(), 10U);
    EXPECT_EQ(sam.bit_rates[0].bps, 2'000'000U);
    EXPECT_EQ(sam.bit_rates[9].code, 9);
    EXPECT_EQ(sam.bit_rates[9].bps, 4800U);
    const Family& nuri = *find_family("nuri");
    EXPECT_EQ(nuri.default_bit_rate, 9600U);
    EXPECT_EQ(nuri.bit_rates.size(), 18U);
    EXPECT_EQ(nuri.bit_rates[13].bps, 115'200U);
    const Family& rmd = *find_family("rmd");
    EXPECT_TRUE(rmd.can);
    EXPECT_EQ(rmd.ids, (wire::Range{1, 32}));
    EXPECT_EQ(rmd.broadcast_id, -1);
    EXPECT_EQ(find_family("dynamixel"), nullptr);
    for (const Family* family : families()) {
        EXPECT_NE(family->protocol, nullptr);
        EXPECT_TRUE(family->ids.contains(family->default_id)) << family->name;
        EXPECT_LE(family->response_time.typical, family->response_time.most) << family->name;
        EXPECT_EQ(family->find_profile(family->profiles.front()->name), family->profiles.front());
        EXPECT_EQ(family->find_profile("none"), nullptr);
    }
}

TEST(Families, EveryProfileHasUniqueMessageNamesAndOpcodes)
{
    for (const Family* family : families())
        for (const wire::Profile* profile : family->profiles) {
            std::set<std::string_view> names;
            std::set<int> opcodes;
            for (const wire::MessageInfo* message : profile->messages) {
                EXPECT_TRUE(names.insert(message->name()).second) << profile->name << " " << message->name();
                if (message->info.opcode >= 0) {
                    EXPECT_TRUE(opcodes.insert(message->info.opcode).second) << profile->name << message->name();
                }
            }
            EXPECT_FALSE(profile->source.empty());
            EXPECT_FALSE(profile->says.empty());
        }
}

TEST(Families, EveryOverrideOfALineNamesAFieldOfOneOfItsMessages)
{
    for (const Family* family : families())
        for (const wire::Profile* profile : family->profiles)
            for (const wire::Override& o : profile->overrides)
                if (const wire::MessageInfo* message = profile->find(o.message)) {
                    const auto fits = [&](const wire::Field& f) { return f.name == o.field; };
                    EXPECT_TRUE(std::ranges::any_of(message->request.fields, fits)) << profile->name << o.message;
                }
}

TEST(Families, EveryModelHasARowOfAssumptionsWithAReason)
{
    for (const Family* family : families())
        for (const ModelInfo& model : family->models) {
            const Assumption* row = assumption(family->name, model.name);
            ASSERT_NE(row, nullptr) << model.name;
            EXPECT_GT(row->inertia_kg_m2, 0.0);
            EXPECT_FALSE(row->reason.empty());
        }
    EXPECT_EQ(assumption("sam", "SAM-160EO200")->stall_torque_nm, 0.0) << "the manual prints it";
    EXPECT_EQ(assumption("sam", "MG"), nullptr);
}

TEST(MakeSpec, FillsInTheDefaultsOfAFamily)
{
    const auto rmd = make_spec(*find_family("rmd"), "", "", 5);
    ASSERT_TRUE(rmd) << to_sentence(rmd.error());
    EXPECT_EQ(model_of(*rmd), "RMD");
    EXPECT_EQ(line_of(*rmd).name, "rmd-2.35");
    EXPECT_EQ(id_of(*rmd), 5);
    EXPECT_EQ(&family_of(*rmd), find_family("rmd"));
    EXPECT_FALSE(std::get<rmd::Spec>(*rmd).profile.max_speed_confirmed) << "nobody named the profile";
    EXPECT_EQ(std::get<rmd::Spec>(*rmd).device.bit_rate, 1'000'000U);
    EXPECT_EQ(line_of(*make_spec(*find_family("nuri"), "MC", "", 0)).name, "mc") << "the line of the model";
}

TEST(MakeSpec, NamingTheProfileConfirmsItsScaleOfMaxSpeed)
{
    const auto named = make_spec(*find_family("rmd"), "MF", "rmd-2.35", 5);
    EXPECT_TRUE(std::get<rmd::Spec>(*named).profile.max_speed_confirmed);
}

TEST(MakeSpec, SaysWhatIsWrongAndWhatIsNear)
{
    const auto sam = make_spec(*find_family("sam"), "", "", 1);
    EXPECT_EQ(sam.error().code, Errc::unknown_name);
    EXPECT_EQ(sam.error().detail.substr(0, 62), "sam needs a model, because every scale depends on it: SAM-5, S");
    EXPECT_EQ(make_spec(*find_family("rmd"), "MX", "", 1).error().detail,
              "rmd has no model 'MX', did you mean MF? It has RMD, MF, MG, MS, RMD-L.");
    EXPECT_EQ(make_spec(*find_family("nuri"), "", "rsb", 1).error().detail,
              "nuri has no profile 'rsb', did you mean rsa? It has rsa, mc.");
    const auto id = make_spec(*find_family("rmd"), "", "", 33);
    EXPECT_EQ(id.error().code, Errc::bad_id);
    EXPECT_EQ(to_sentence(id.error()), "rmd has ids from 1 to 32, not 33.");
}

TEST(Resolve, AnUnknownModelSuggestsTheNearest)
{
    EXPECT_EQ(complaint("[joint.a]\nbus = \"s\"\nid = 1\nmodel = \"SAM-29\"\n"),
              "r.toml:11:9: sam has no model 'SAM-29', did you mean SAM-20? It has SAM-5, SAM-20, SAM-28, "
              "SAM-160EO200, SAM-180EO200, SAM-210EO200.");
    EXPECT_EQ(complaint("[joint.a]\nbus = \"s\"\nid = 1\n").substr(0, 30), "r.toml:8:8: sam needs a model,");
}

TEST(Resolve, AnUnknownProfileSuggestsTheNearest)
{
    EXPECT_EQ(complaint("[joint.a]\nbus = \"r\"\nid = 1\nprofile = \"lk-2.37\"\n"),
              "r.toml:11:11: rmd has no profile 'lk-2.37', did you mean lk-2.35? It has rmd-2.35, lk-2.35, lk-2.36, "
              "gyems-1.62, myactuator-3.");
}

TEST(Resolve, AnIdThatTheFamilyCannotAddressIsRefused)
{
    EXPECT_EQ(complaint("[joint.a]\nbus = \"r\"\nid = 0\n"), "r.toml:10:6: rmd has ids from 1 to 32, not 0.");
    EXPECT_EQ(complaint("[joint.a]\nbus = \"n\"\nid = 255\n"), "r.toml:10:6: nuri has ids from 0 to 254, not 255.");
    EXPECT_EQ(complaint("[joint.a]\nbus = \"n\"\nid = 4294967297\n"),
              "r.toml:10:6: nuri has ids from 0 to 254, not 4294967297.");
    EXPECT_EQ(complaint("[joint.a]\nbus = \"n\"\nid = 254\n"), "nothing");
}

TEST(Resolve, TwoJointsWithOneIdOnABusAreRefused)
{
    EXPECT_EQ(complaint("[joint.a]\nbus = \"n\"\nid = 1\n[joint.b]\nbus = \"n\"\nid = 1\n"),
              "r.toml:13:6: id 1 on bus n belongs to joint a already (line 10).");
    EXPECT_EQ(complaint("[joint.a]\nbus = \"n\"\nid = 1\n[joint.b]\nbus = \"r\"\nid = 1\n"), "nothing");
}

TEST(Resolve, AnUnknownOptionIsReportedWithItsPlaceAndTheNearest)
{
    const std::string joint = "[joint.a]\nbus = \"s\"\nid = 1\nmodel = \"SAM-5\"\n";
    EXPECT_EQ(
        complaint(joint + "[joint.a.profile_options]\nquick_boundry_order = \"lower_first\"\n").substr(0, 103),
        "r.toml:13:1: sam-1.0 has no profile option 'quick_boundry_order', did you mean quick_boundary_order? It");
    EXPECT_EQ(complaint(joint + "[joint.a.sim]\nresponse_levle = 1\n").substr(0, 80),
              "r.toml:13:1: sam has no sim option 'response_levle', did you mean response_level");
}

TEST(Resolve, AnOptionWithAWrongValueSaysWhatItMayBe)
{
    const std::string joint = "[joint.a]\nbus = \"r\"\nid = 1\n[joint.a.profile_options]\n";
    EXPECT_EQ(complaint(joint + "max_speed_lsb_dps = 0.1\n"), "r.toml:12:1: max_speed_lsb_dps must be 0.01 or 1.");
    EXPECT_EQ(complaint(joint + "encoder_bits = 19\n"), "r.toml:12:1: encoder_bits must be 12 to 18.");
    EXPECT_EQ(complaint(joint + "off_requires_run = 1\n"), "r.toml:12:1: off_requires_run must be true or false.");
    EXPECT_EQ(complaint(joint + "clear_error_reply = \"0x9C\"\n"),
              "r.toml:12:1: clear_error_reply must be \"0x9A\" or \"0x9B\".");
    EXPECT_EQ(complaint(joint + "torque_current_full_scale_a = nan\n"),
              "r.toml:12:1: torque_current_full_scale_a must be amperes at 2048, above 0.");
}

TEST(Resolve, AnUnknownFamilyOrBitRateIsReported)
{
    const auto fails = [](const char* text) {
        return resolve(*config::parse_robot_file(text, "r.toml")).error().detail;
    };
    EXPECT_EQ(fails("version = 1\n[bus.a]\nfamily = \"nury\"\n"),
              "r.toml:3:10: sinew has no family 'nury', did you mean nuri? It has sam, nuri, rmd.");
    EXPECT_EQ(fails("version = 1\n[bus.a]\nfamily = \"rmd\"\nbit_rate = 250000\n"),
              "r.toml:4:12: rmd has no bit rate 250000. It has 1000000, 500000.");
}

TEST(Resolve, NamedOptionsReachTheProfileAndTheDevice)
{
    const auto device = only_device("[joint.a]\nbus = \"s\"\nid = 3\nmodel = \"SAM-160\"\n[joint.a.profile_options]\n"
                                    "quick_boundary_order = \"lower_first\"\nquick_port_bits = \"do_low\"\n"
                                    "wheel_reply = \"id_id\"\n[joint.a.sim]\noverload_resume = \"stay_passive\"\n"
                                    "boundary_storage = \"shared_raw\"\nfixed_overload_a = 2\n");
    const auto& spec = std::get<sam::Spec>(device);
    EXPECT_EQ(options_of(device).bits, sam::quick_boundary_lower_first | sam::quick_port_outputs_low);
    EXPECT_EQ(line_of(device).options.bits, options_of(device).bits);
    EXPECT_EQ(spec.profile.wheel_reply, sam::WheelReply::id_id);
    EXPECT_EQ(spec.device.overload_resume, sam::OverloadResume::stay_passive);
    EXPECT_EQ(spec.device.boundary_storage, sam::BoundaryStorage::shared_raw);
    EXPECT_EQ(spec.device.fixed_overload_a, 2.0);
    EXPECT_EQ(spec.device.bit_rate, 115'200U) << "that of the bus";
    EXPECT_EQ(overrides_of(device).data(), spec.model->overrides.data());
}

TEST(Resolve, NamingTheScaleOrTheProfileOfAnRmdConfirmsIt)
{
    const auto confirmed = [](const std::string& lines) {
        const auto device = only_device("[joint.a]\nbus = \"r\"\nid = 3\n" + lines);
        return std::get<rmd::Spec>(device).profile.max_speed_confirmed;
    };
    EXPECT_FALSE(confirmed(""));
    EXPECT_TRUE(confirmed("profile = \"rmd-2.35\"\n"));
    EXPECT_TRUE(confirmed("[joint.a.profile_options]\nmax_speed_lsb_dps = 1\n"));
}

TEST(Resolve, ASimulatedSamStartsWithTheResponseLevelOfItsProfileUnlessToldOtherwise)
{
    const std::string joint = "[joint.a]\nbus = \"s\"\nid = 3\nmodel = \"SAM-5\"\n";
    const auto silent = only_device(joint);
    EXPECT_FALSE(answers(silent, wire::info_of<sam::SetPdGain>));
    EXPECT_TRUE(answers(silent, wire::info_of<sam::ReadPdGain>));
    const auto same = only_device(joint + "[joint.a.profile_options]\nresponse_level = 1\n");
    EXPECT_TRUE(answers(same, wire::info_of<sam::SetPdGain>));
    EXPECT_EQ(std::get<sam::Spec>(same).device.response_level, 1);
    const auto other = only_device(joint + "[joint.a.profile_options]\nresponse_level = 1\n[joint.a.sim]\n"
                                           "response_level = 2\n");
    EXPECT_TRUE(answers(other, wire::info_of<sam::SetPdGain>)) << "the host goes by the profile";
    EXPECT_EQ(std::get<sam::Spec>(other).device.response_level, 2);
    EXPECT_FALSE(answers(only_device(joint + "[joint.a.profile_options]\nresponse_level = 2\n"),
                         wire::info_of<sam::ReadPdGain>));
}

TEST(Resolve, WithoutControlDirectionTheMessageIsRefused)
{
    const auto with = only_device("[joint.a]\nbus = \"n\"\nid = 3\n");
    EXPECT_TRUE(line_of(with).has(wire::info_of<nuri::SetControlDirection>));
    EXPECT_FALSE(answers(with, wire::info_of<nuri::SetControlDirection>));
    const auto without =
        only_device("[joint.a]\nbus = \"n\"\nid = 3\n[joint.a.profile_options]\ncontrol_direction = false\n");
    EXPECT_FALSE(line_of(without).has(wire::info_of<nuri::SetControlDirection>));
    EXPECT_EQ(line_of(without).messages.size(), line_of(with).messages.size() - 1);
}

TEST(Resolve, TimesComeFromTheDevice)
{
    const auto slow =
        only_device("[joint.a]\nbus = \"n\"\nid = 3\n[joint.a.profile_options]\nresponse_time_us = 5000\n");
    EXPECT_EQ(response_time_of(slow), std::chrono::milliseconds{5});
    EXPECT_EQ(response_time_of(only_device("[joint.a]\nbus = \"r\"\nid = 3\n")), std::chrono::microseconds{250});
}

// ---- [joint.NAME.runtime] ----

TEST(Resolve, ReadsWhatADeviceIsSetToAfterPowerOn)
{
    const auto sam = std::get<sam::Spec>(only_device("[joint.j]\nbus = \"s\"\nid = 1\nmodel = \"SAM-20\"\n"
                                                     "[joint.j.runtime]\np_gain = 40\nd_gain = 8\n"));
    EXPECT_EQ(sam.runtime.p_gain, 40);
    EXPECT_EQ(sam.runtime.d_gain, 8);
    EXPECT_EQ(sam.runtime.i_gain, std::nullopt);
    const auto rmd = std::get<rmd::Spec>(only_device("[joint.j]\nbus = \"r\"\nid = 1\n[joint.j.runtime]\n"
                                                     "acceleration_deg_s2 = 180\nspeed_kp = 7\nspeed_ki = 8\n"
                                                     "speed_kd = 9\n"));
    EXPECT_NEAR(rmd.runtime.acceleration_rad_s2.value(), 3.14159265, 1e-6);
    EXPECT_EQ(rmd.runtime.speed.kd, 9);
    EXPECT_FALSE(rmd.runtime.angle.given());
}

TEST(Resolve, SaysWhatIsWrongWithRunTimeSettings)
{
    const auto about = [](std::string_view joint, std::string_view settings) {
        return complaint(fmt::format("[joint.j]\n{}\nid = 1\n[joint.j.runtime]\n{}\n", joint, settings));
    };
    const std::string_view sam = "bus = \"s\"\nmodel = \"SAM-20\"";
    const auto rmd = [](std::string_view line) { return fmt::format("bus = \"r\"\nprofile = \"{}\"", line); };
    for (const auto& [said, expected] :
         {std::pair{about(sam, "p_gain = 40"), "give both"},
          {about(sam, "p_gain = 0\nd_gain = 1"), "1 to 254"},
          {about(sam, "p_gian = 40"), "did you mean p_gain"},
          {about("bus = \"n\"", "p_gain = 1"), "keeps every setting"},
          {about(rmd("rmd-2.35"), "angle_kp = 1\nangle_ki = 1"), "give all three"},
          {about(rmd("rmd-2.35"), "acceleration_rad_s2 = 0"), "above 0"},
          {about(rmd("gyems-1.62"), "angle_kp = 1\nangle_ki = 1"), "all three loops"},
          {about(rmd("gyems-1.62"), "angle_kp = 1\nangle_ki = 1\nangle_kd = 1"), "kp and ki"},
          {about(rmd("lk-2.35"), "acceleration_rad_s2 = 1"), "no message for an acceleration"},
          {about(rmd("lk-2.35"), "angle_kp = 1\nangle_ki = 1\nangle_kd = 1"), "no message for gains"}}) {
        EXPECT_NE(said.find(expected), std::string::npos) << said;
        EXPECT_EQ(said.substr(0, 7), "r.toml:") << said;
    }
}

} // namespace
} // namespace sinew
