#include "sinew/family/sam/framing.hpp"
#include "tests/fuzz/framing.hpp"

/// Any bytes as what a SAM device hears.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    sinew::fuzz::claim_framing({data, size}, [](std::span<const std::uint8_t> bytes, bool silent) {
        return sinew::sam::protocol().find_request(bytes, silent);
    });
    return 0;
}
