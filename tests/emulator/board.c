/* An emulated ATmega board for tests: a flat C interface over libsimavr, for ctypes. Time moves only in board_run.
 *
 * libsimavr 1.6 differs from the chip where it matters to a serial robot; what is put right here:
 * - it takes 11 bits for a byte of 8N1: the baud generator's real 10 are set whenever the firmware sets its rate;
 * - its receiver holds 63 bytes and so never overruns: the chip holds two and the one in its shift register;
 * - it reports a sent byte when the firmware writes it: on the wire it ends a byte's time later;
 * - it reports a store outside of the RAM and then makes it all the same: there is room for that, and it is an error;
 * - a reset, by the button or by the watchdog, makes it forget what it was to call: it is told again.
 *
 * libsimavr is under the GPL 3: this is a tool of the tests and no part of what is installed.
 */
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <avr_adc.h>
#include <avr_extint.h>
#include <avr_ioport.h>
#include <avr_uart.h>
#include <sim_avr.h>
#include <sim_elf.h>
#include <sim_time.h>

DEFINE_FIFO(uint16_t, uart_fifo);

enum { PORT_COUNT = 3, PIN_COUNT = 8, CHIP_RECEIVER_BYTES = 3, ADDRESS_SPACE = 0x10000, PAINT = 0xA5 };

typedef struct {
  uint64_t cycle;
  uint32_t what;
} Stamped;

typedef struct {
  Stamped *items;
  size_t count, room;
} Log;

typedef struct Board {
  avr_t *avr;
  elf_firmware_t firmware;
  avr_uart_t *uart;
  avr_irq_t *input;
  double byte_cycles;                /* of the firmware's own rate: 10 bits */
  avr_cycle_count_t patched;         /* what the emulator was told that this is */
  Log arriving, sent, edges;
  size_t next;                       /* of what is arriving */
  double arriving_cycles;            /* a byte's time at the sender's rate */
  int is_in_shift_register;
  uint64_t sender_free;
  uint64_t overruns;
  uint32_t free_ram;
  size_t wanted;                     /* sent bytes to stop at; 0: none */
  int is_due;
  void (*chip_reset)(avr_t *);       /* the emulator's own */
  int was_reset;
} Board;

static char complaints[4096];

static void complain(avr_t *avr, const int level, const char *format, va_list arguments) {
  (void)avr;
  char said[256];
  vsnprintf(said, sizeof said, format, arguments);
  /* A compare value may be set while a timer's clock is off: tone() does so. */
  size_t used = strlen(complaints);
  if (level <= LOG_WARNING && used + 1 < sizeof complaints && strstr(said, "mode 0 UNSUPPORTED") == NULL) {
    snprintf(complaints + used, sizeof complaints - used, "%s", said);
  }
}

static void add(Log *log, uint64_t cycle, uint32_t what) {
  if (log->count == log->room) {
    log->room = log->room ? 2 * log->room : 1024;
    log->items = realloc(log->items, log->room * sizeof *log->items);
  }
  log->items[log->count++] = (Stamped){cycle, what};
}

static void set_byte_time(Board *board) {
  avr_uart_t *uart = board->uart;
  if (uart->cycles_per_byte == board->patched) {
    return;
  }
  uint32_t divider = avr_regbit_get(board->avr, uart->ubrrl) | (avr_regbit_get(board->avr, uart->ubrrh) << 8);
  double bit = (divider + 1) * (avr_regbit_get(board->avr, uart->u2x) ? 8.0 : 16.0);
  board->byte_cycles = 10.0 * bit;
  uart->cycles_per_byte = board->patched = (avr_cycle_count_t)board->byte_cycles;
}

static void on_sent(struct avr_irq_t *irq, uint32_t value, void *context) {
  (void)irq;
  Board *board = context;
  set_byte_time(board);
  uint64_t begin = board->avr->cycle > board->sender_free ? board->avr->cycle : board->sender_free;
  board->sender_free = begin + (uint64_t)board->byte_cycles;
  add(&board->sent, board->sender_free, value & 0xFF);
  if (board->wanted && board->sent.count >= board->wanted) {
    board->is_due = 1;
  }
}

typedef struct {
  Board *board;
  uint8_t port, pin;
} Pin;

static Pin *pins_of(Board *board) {
  Pin *pins = calloc(PORT_COUNT * PIN_COUNT, sizeof *pins);
  for (int at = 0; at < PORT_COUNT * PIN_COUNT; ++at) {
    pins[at] = (Pin){board, (uint8_t)('B' + at / PIN_COUNT), (uint8_t)(at % PIN_COUNT)};
  }
  return pins;
}

static void on_level(struct avr_irq_t *irq, uint32_t value, void *context) {
  (void)irq;
  Pin *pin = context;
  add(&pin->board->edges, pin->board->avr->cycle, ((uint32_t)pin->port << 16) | ((uint32_t)pin->pin << 8) | ((value & 0xFF) != 0));
}

/* Called at a byte's start bit, then at its end. */
static avr_cycle_count_t on_arriving(struct avr_t *avr, avr_cycle_count_t when, void *context) {
  Board *board = context;
  avr_uart_t *uart = board->uart;
  if (!board->is_in_shift_register) {
    if (uart_fifo_get_read_size(&uart->input) >= CHIP_RECEIVER_BYTES) { /* the one that waits there is lost */
      uart->input.write = (uint16_t)((uart->input.write + uart_fifo_fifo_size - 1) % uart_fifo_fifo_size);
      ++board->overruns;
    }
    board->is_in_shift_register = 1;
    return when + (avr_cycle_count_t)board->arriving_cycles;
  }
  board->is_in_shift_register = 0;
  Stamped byte = board->arriving.items[board->next++];
  if (avr_regbit_get(avr, uart->rxen)) {
    uart->cycles_per_byte = 1; /* it is there now, not a byte's time later */
    avr_raise_irq(board->input, byte.what);
    uart->cycles_per_byte = board->patched;
  }
  if (board->next == board->arriving.count) {
    return 0;
  }
  uint64_t start = board->arriving.items[board->next].cycle;
  return start > when ? start : when + 1;
}

static avr_cycle_count_t on_due(struct avr_t *avr, avr_cycle_count_t when, void *context) {
  (void)avr, (void)when;
  ((Board *)context)->is_due = 1;
  return 0;
}

static void do_not_sleep(avr_t *avr, avr_cycle_count_t cycles) { (void)avr, (void)cycles; }

static void attach(Board *board, Pin *pins) {
  avr_t *avr = board->avr;
  avr->sleep = do_not_sleep;
  for (int at = 0; at < PORT_COUNT * PIN_COUNT; ++at) {
    avr_irq_t *irq = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ(pins[at].port), pins[at].pin);
    if (irq) {
      avr_irq_register_notify(irq, on_level, &pins[at]);
    }
  }
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), on_sent, board);
  board->input = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
  for (avr_io_t *io = avr->io_port; io; io = io->next) {
    if (io->kind && strcmp(io->kind, "uart") == 0) {
      board->uart = (avr_uart_t *)io;
    }
  }
  avr_extint_set_strict_lvl_trig(avr, 0, 0); /* else it looks at each cycle whether pins 2 and 3 are low: 20 times slower */
  avr_extint_set_strict_lvl_trig(avr, 1, 0);
  uint32_t flags = 0; /* no echo on the terminal, no sleep when the firmware polls */
  avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
}

static void on_reset(avr_t *avr) {
  Board *board = avr->custom.data;
  board->was_reset = 1;
  if (board->chip_reset) {
    board->chip_reset(avr);
  }
}

/* What is on the wire comes all the same, but for the byte that the receiver was at. */
static void go_on_arriving(Board *board) {
  avr_t *avr = board->avr;
  if (board->next < board->arriving.count && !avr_cycle_timer_status(avr, on_arriving, board)) {
    uint64_t start = board->arriving.items[board->next].cycle;
    avr_cycle_timer_register(avr, start > avr->cycle ? start - avr->cycle : 1, on_arriving, board);
  }
}

static void after_reset(Board *board) {
  board->was_reset = 0;
  board->avr->sleep = do_not_sleep;
  board->patched = 0;
  if (board->is_in_shift_register) {
    board->is_in_shift_register = 0;
    ++board->next;
  }
  go_on_arriving(board);
}

static void paint(Board *board) {
  memset(board->avr->data + board->free_ram, PAINT, board->avr->ramend + 1 - board->free_ram);
}

/* With a program, or with the flash erased if there is none. */
Board *board_new(const char *elf, const char *chip, uint32_t frequency) {
  avr_global_logger_set(complain);
  Board *board = calloc(1, sizeof *board);
  if ((elf && elf_read_firmware(elf, &board->firmware) != 0) || (board->avr = avr_make_mcu_by_name(chip)) == NULL) {
    free(board);
    return NULL;
  }
  board->avr->custom.data = board;
  avr_init(board->avr);
  board->chip_reset = board->avr->reset;
  board->avr->reset = on_reset;
  board->avr->data = realloc(board->avr->data, ADDRESS_SPACE);
  memset(board->avr->data + board->avr->ramend + 1, 0, ADDRESS_SPACE - board->avr->ramend - 1);
  if (elf) {
    board->firmware.frequency = frequency;
    avr_load_firmware(board->avr, &board->firmware);
  }
  board->avr->frequency = frequency;
  board->avr->vcc = board->avr->avcc = board->avr->aref = 5000;
  board->avr->log = LOG_WARNING;
  attach(board, pins_of(board));
  board->free_ram = (uint32_t)board->avr->ioend + 1;
  for (uint32_t at = 0; at < board->firmware.symbolcount; ++at) {
    if (strcmp(board->firmware.symbol[at]->symbol, "_end") == 0) {
      board->free_ram = board->firmware.symbol[at]->addr & 0xFFFF;
    }
  }
  paint(board);
  return board;
}

/* Run to a cycle, or until so many bytes were sent in all (0: no matter). Returns whether the chip still works. */
int board_run(Board *board, uint64_t until, size_t wanted) {
  avr_t *avr = board->avr;
  board->wanted = wanted;
  board->is_due = until <= avr->cycle || (wanted && board->sent.count >= wanted);
  if (!board->is_due) {
    avr_cycle_timer_register(avr, until - avr->cycle, on_due, board);
  }
  avr->run_cycle_limit = 1000;
  while (!board->is_due && avr->state != cpu_Done && avr->state != cpu_Crashed) {
    avr_run(avr);
    if (board->was_reset) {
      after_reset(board);
      if (until > avr->cycle) {
        avr_cycle_timer_register(avr, until - avr->cycle, on_due, board);
      } else {
        board->is_due = 1;
      }
    }
    set_byte_time(board);
  }
  avr_cycle_timer_cancel(avr, on_due, board);
  return avr->state != cpu_Done && avr->state != cpu_Crashed && complaints[0] == '\0';
}

/* Put bytes on the wire, behind those that are there, at the sender's rate; not before a cycle. */
void board_receive(Board *board, const uint8_t *bytes, size_t count, uint64_t from, double byte_cycles, double gap_cycles) {
  avr_t *avr = board->avr;
  double at = (double)(from > avr->cycle ? from : avr->cycle + 1);
  if (board->next < board->arriving.count) {
    double behind = (double)board->arriving.items[board->arriving.count - 1].cycle + board->arriving_cycles;
    at = behind > at ? behind : at;
  }
  board->arriving_cycles = byte_cycles;
  for (size_t number = 0; number < count; ++number) {
    add(&board->arriving, (uint64_t)at, bytes[number]);
    at += byte_cycles + gap_cycles;
  }
  if (!board->is_in_shift_register) {
    go_on_arriving(board);
  }
}

/* The chip is reset, as by its button; what is on the wire stays there. */
void board_reset(Board *board) {
  avr_reset(board->avr);
  avr_regbit_set(board->avr, board->avr->reset_flags.extrf);
  after_reset(board);
  paint(board);
}

/* Where a reset leads to, as its fuses say, and to there at once: the board has been without power. */
void board_power_on(Board *board, uint32_t address) {
  board->next = board->arriving.count;
  board->is_in_shift_register = 0;
  board->avr->reset_pc = address;
  avr_reset(board->avr);
  avr_regbit_set(board->avr, board->avr->reset_flags.porf);
  after_reset(board);
  paint(board);
}

uint8_t *board_flash(Board *board) { return board->avr->flash; }

void board_free(Board *board) {
  avr_terminate(board->avr);
  free(board->arriving.items);
  free(board->sent.items);
  free(board->edges.items);
  free(board);
}

static size_t taken(const Log *log, size_t from, Stamped *out, size_t room) {
  size_t count = log->count > from ? log->count - from : 0;
  count = count < room ? count : room;
  memcpy(out, log->items + from, count * sizeof *out);
  return count;
}

size_t board_sent(Board *board, size_t from, Stamped *out, size_t room) { return taken(&board->sent, from, out, room); }
size_t board_edges(Board *board, size_t from, Stamped *out, size_t room) { return taken(&board->edges, from, out, room); }
uint64_t board_cycle(Board *board) { return board->avr->cycle; }
double board_byte_cycles(Board *board) { return board->byte_cycles; }
uint64_t board_overruns(Board *board) { return board->overruns; }
uint8_t board_peek(Board *board, uint16_t address) { return board->avr->data[address]; }
void board_press(Board *board, char port, int pin, int level) {
  avr_raise_irq(avr_io_getirq(board->avr, AVR_IOCTL_IOPORT_GETIRQ(port), pin), (uint32_t)level);
}

void board_voltage(Board *board, int channel, uint32_t millivolts) {
  avr_raise_irq(avr_io_getirq(board->avr, AVR_IOCTL_ADC_GETIRQ, channel), millivolts);
}

/* How many bytes of RAM the stack has never touched. */
uint32_t board_untouched(Board *board) {
  uint32_t at = board->free_ram;
  while (at <= board->avr->ramend && board->avr->data[at] == PAINT) {
    ++at;
  }
  return at - board->free_ram;
}

const char *board_complaints(void) { return complaints; }
void board_forgive(void) { complaints[0] = '\0'; }
