#include "sinew/family/rmd/lines.hpp"
#include "sinew/family/rmd/messages.hpp"
#include "tests/fuzz/decoding.hpp"

namespace rmd = sinew::rmd;

/// Any bytes as a CAN frame for every RMD row, by name and typed.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    const auto in = sinew::fuzz::to_input({data, size}, true);
    sinew::fuzz::claim_all_rows(*sinew::find_family("rmd"), in);
    sinew::fuzz::claim_typed<rmd::ManualMessages>(in);
    sinew::fuzz::claim_typed<rmd::Lk235Messages>(in);
    sinew::fuzz::claim_typed<rmd::Lk236Messages>(in);
    sinew::fuzz::claim_typed<rmd::Gyems162Messages>(in);
    sinew::fuzz::claim_typed<rmd::MyActuator3Messages>(in);
    return 0;
}
