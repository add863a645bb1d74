/* Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
 *
 * Plugin of QEMU's user mode: counts the instructions that the calls of one function take, with all
 * that it calls, and how often it is called. tests/cross_aarch64.sh compiles it for this machine.
 *   gcc -shared -fPIC -O2 -o libcount.so count_instructions.c
 *   qemu-aarch64 -d plugin -plugin ./libcount.so,function=TEXT PROGRAM...
 * TEXT: part of the function's linker name. The program has its symbols and is of one thread.
 *
 * Distributions do not package qemu-plugin.h, hence the declarations of what is used of it (version
 * 1 of the interface, QEMU 4.2 to 9.0).
 */
#include <inttypes.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))
typedef uint64_t qemu_plugin_id_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
typedef struct qemu_info_t qemu_info_t;
enum qemu_plugin_cb_flags { QEMU_PLUGIN_CB_NO_REGS };
typedef void (*vcpu_tb_trans_cb)(qemu_plugin_id_t id, struct qemu_plugin_tb* tb);
typedef void (*vcpu_udata_cb)(unsigned vcpu, void* data);
typedef void (*udata_cb)(qemu_plugin_id_t id, void* data);
void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t id, vcpu_tb_trans_cb callback);
void qemu_plugin_register_vcpu_tb_exec_cb(struct qemu_plugin_tb* tb, vcpu_udata_cb callback,
                                          enum qemu_plugin_cb_flags flags, void* data);
void qemu_plugin_register_atexit_cb(qemu_plugin_id_t id, udata_cb callback, void* data);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb* tb);
uint64_t qemu_plugin_tb_vaddr(const struct qemu_plugin_tb* tb);
struct qemu_plugin_insn* qemu_plugin_tb_get_insn(const struct qemu_plugin_tb* tb, size_t index);
uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn* insn);
size_t qemu_plugin_insn_size(const struct qemu_plugin_insn* insn);
const char* qemu_plugin_insn_symbol(const struct qemu_plugin_insn* insn);
void qemu_plugin_outs(const char* text);

EXPORT int qemu_plugin_version = 1;

/* A block of instructions, run from its first to its last. Kept for the whole run: QEMU translates
 * a block again where it has thrown it away. */
typedef struct {
  uint64_t begin, end; /* address of the first instruction, and after the last */
  uint64_t instructions;
  bool of_function;
} Block;

static char function[256];
static const Block* last;  /* run before this one */
static bool inside;        /* the function was called and has not returned */
static uint64_t return_to; /* where it returns to: behind the call */
static uint64_t calls, counted, all;

static void run(unsigned vcpu, void* data) {
  (void)vcpu;
  const Block* block = data;
  if (inside && block->begin == return_to) inside = false;
  if (!inside && block->of_function && last != NULL) {
    inside = true;
    return_to = last->end;
    ++calls;
  }
  if (inside) counted += block->instructions;
  all += block->instructions;
  last = block;
}

static void translated(qemu_plugin_id_t id, struct qemu_plugin_tb* tb) {
  (void)id;
  const size_t size = qemu_plugin_tb_n_insns(tb);
  Block* block = malloc(sizeof *block);
  if (block == NULL || size == 0) abort();
  const struct qemu_plugin_insn* end = qemu_plugin_tb_get_insn(tb, size - 1);
  const char* symbol = qemu_plugin_insn_symbol(qemu_plugin_tb_get_insn(tb, 0));
  block->begin = qemu_plugin_tb_vaddr(tb);
  block->end = qemu_plugin_insn_vaddr(end) + qemu_plugin_insn_size(end);
  block->instructions = size;
  block->of_function = symbol != NULL && strstr(symbol, function) != NULL;
  qemu_plugin_register_vcpu_tb_exec_cb(tb, run, QEMU_PLUGIN_CB_NO_REGS, block);
}

static void report(qemu_plugin_id_t id, void* data) {
  (void)id;
  (void)data;
  char text[512];
  snprintf(text, sizeof text,
           "%s: %" PRIu64 " calls, %" PRIu64 " instructions, of %" PRIu64 " of the program\n",
           function, calls, counted, all);
  qemu_plugin_outs(text);
}

EXPORT int qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t* info, int argc,
                               char** argv) {
  (void)info;
  static const char key[] = "function=";
  if (argc != 1 || strncmp(argv[0], key, sizeof key - 1) != 0 ||
      strlen(argv[0] + sizeof key - 1) >= sizeof function || argv[0][sizeof key - 1] == '\0') {
    fputs("count_instructions: give function=PART_OF_A_LINKER_NAME\n", stderr);
    return -1;
  }
  strcpy(function, argv[0] + sizeof key - 1);
  qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
  qemu_plugin_register_atexit_cb(id, report, NULL);
  return 0;
}
