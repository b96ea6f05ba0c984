#include "sinew/family/sam/messages.hpp"
#include "tests/fuzz/decoding.hpp"

/// Any bytes as a frame for every SAM row, by name and typed.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    const auto in = sinew::fuzz::to_input({data, size}, false);
    sinew::fuzz::claim_all_rows(*sinew::find_family("sam"), in);
    sinew::fuzz::claim_typed<sinew::sam::ManualMessages>(in);
    return 0;
}
