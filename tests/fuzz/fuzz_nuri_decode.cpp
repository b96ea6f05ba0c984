#include "sinew/family/nuri/lines.hpp"
#include "sinew/family/nuri/messages.hpp"
#include "tests/fuzz/decoding.hpp"

/// Any bytes as a frame for every Nuri row, by name and typed.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    const auto in = sinew::fuzz::to_input({data, size}, false);
    sinew::fuzz::claim_all_rows(*sinew::find_family("nuri"), in);
    sinew::fuzz::claim_typed<sinew::nuri::ManualMessages>(in);
    sinew::fuzz::claim_typed<sinew::nuri::mc::Messages>(in);
    return 0;
}
