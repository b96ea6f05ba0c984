#include "sinew/link/can_error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <linux/can.h>
#include <linux/can/error.h>

namespace sinew::link {
namespace {

constexpr int no_detail = -1;

struct Row {
    std::uint32_t kind;
    int place;         ///< of the byte that has the details, or `no_detail`
    std::uint8_t bits; ///< of that byte; 0: it says none that is known
    std::string_view word;
    std::string_view says;
};

constexpr Row rows[] = {
    {CAN_ERR_TX_TIMEOUT, no_detail, 0, "send-timeout", "a frame could not be sent in time"},
    {CAN_ERR_LOSTARB, no_detail, 0, "arbitration-lost", "another frame was more urgent than ours"},
    {CAN_ERR_CRTL, 1, CAN_ERR_CRTL_RX_OVERFLOW, "receive-overflow", "frames were lost, for nobody fetched them"},
    {CAN_ERR_CRTL, 1, CAN_ERR_CRTL_TX_OVERFLOW, "send-overflow", "frames to be sent were lost"},
    {CAN_ERR_CRTL, 1, CAN_ERR_CRTL_RX_WARNING, "error-warning-receiving", "many errors while receiving"},
    {CAN_ERR_CRTL, 1, CAN_ERR_CRTL_TX_WARNING, "error-warning-sending", "many errors while sending"},
    {CAN_ERR_CRTL, 1, CAN_ERR_CRTL_RX_PASSIVE, "error-passive-receiving", "error passive, for it receives with errors"},
    {CAN_ERR_CRTL, 1, CAN_ERR_CRTL_TX_PASSIVE, "error-passive-sending", "error passive, for it sends with errors"},
    {CAN_ERR_CRTL, 1, CAN_ERR_CRTL_ACTIVE, "error-active", "error active again: all is well"},
    {CAN_ERR_CRTL, 1, 0, "controller-problem", "a problem that it does not name"},
    {CAN_ERR_PROT, 2, CAN_ERR_PROT_BIT, "bit-error", "a bit was not the one that was sent"},
    {CAN_ERR_PROT, 2, CAN_ERR_PROT_FORM, "form-error", "a frame of a wrong form"},
    {CAN_ERR_PROT, 2, CAN_ERR_PROT_STUFF, "stuff-error", "more equal bits in a row than there may be"},
    {CAN_ERR_PROT, 2, CAN_ERR_PROT_BIT0, "bit-0-error", "a dominant bit could not be sent"},
    {CAN_ERR_PROT, 2, CAN_ERR_PROT_BIT1, "bit-1-error", "a recessive bit could not be sent"},
    {CAN_ERR_PROT, 2, CAN_ERR_PROT_OVERLOAD, "overload", "somebody on the bus is overloaded"},
    {CAN_ERR_PROT, 2, CAN_ERR_PROT_ACTIVE, "error-announced", "an error was announced on the bus"},
    {CAN_ERR_PROT, 2, CAN_ERR_PROT_TX, "while-sending", "that was while it sent"},
    {CAN_ERR_PROT, 2, 0, "protocol-error", "a frame that breaks the protocol"},
    {CAN_ERR_TRX, no_detail, 0, "transceiver", "its transceiver finds a wire cut or shorted"},
    {CAN_ERR_ACK, no_detail, 0, "no-acknowledgement", "nobody on the bus acknowledged a frame"},
    {CAN_ERR_BUSOFF, no_detail, 0, "bus-off", "bus-off: it saw too many errors and fell silent"},
    {CAN_ERR_BUSERROR, no_detail, 0, "bus-error", "an error on the bus"},
    {CAN_ERR_RESTARTED, no_detail, 0, "restarted", "it started again after bus-off"},
};
/// The counters are no event, and are told beside it.
constexpr std::uint32_t has_counters = CAN_ERR_CNT;

constexpr std::uint8_t bits_of(std::uint32_t kind)
{
    std::uint8_t all = 0;
    for (const Row& row : rows)
        if (row.kind == kind)
            all = static_cast<std::uint8_t>(all | row.bits);
    return all;
}

bool applies(const Row& row, const wire::Frame& error)
{
    if ((error.can_id & row.kind) == 0)
        return false;
    if (row.place == no_detail)
        return true;
    const std::uint8_t said = row.place < error.size ? error.data[static_cast<std::size_t>(row.place)] : 0;
    return row.bits != 0 ? (said & row.bits) != 0 : (said & bits_of(row.kind)) == 0;
}

std::vector<std::string> tell(const wire::Frame& error, std::string_view Row::* what)
{
    std::vector<std::string> out;
    std::uint32_t known = has_counters;
    for (const Row& row : rows) {
        known |= row.kind;
        if (applies(row, error))
            out.emplace_back(row.*what);
    }
    if (const std::uint32_t rest = error.can_id & CAN_ERR_MASK & ~known; rest != 0)
        out.push_back(fmt::format("class-0x{:X}", rest));
    return out;
}

} // namespace

std::vector<std::string> can_error_words(const wire::Frame& error)
{
    return tell(error, &Row::word);
}

std::string can_error_sentence(const wire::Frame& error)
{
    constexpr std::size_t sending = 6, receiving = 7; // places of the two counters
    const auto all = tell(error, &Row::says);
    std::string out = fmt::format("the CAN controller reports: {}", fmt::join(all, ", "));
    if ((error.can_id & has_counters) != 0 && error.size > receiving)
        out += fmt::format("{}error counters: {} sending, {} receiving", all.empty() ? "" : "; ", error.data[sending],
                           error.data[receiving]);
    return out;
}

} // namespace sinew::link
