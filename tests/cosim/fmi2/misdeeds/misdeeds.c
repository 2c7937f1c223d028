/* An FMI 2.0 co-simulation FMU that integrates its input, and does one misdeed at one place.

   Its name says which and where: "step__segfault". Places are instantiate, set, get, step and free; each is reached
   again and again, and the misdeed is done the third time, or the first where there is but one. The moment it is done
   it makes the file that the environment variable MISDEED names. What returns from a misdeed goes on as if nothing had
   happened, with the right numbers. For Linux. */
#define _GNU_SOURCE
#include <dirent.h>
#include <fcntl.h>
#include <fenv.h>
#include <locale.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>
#include "fmi2Functions.h"

enum { VR_U, VR_Y };
enum { DESCRIPTORS = 1024, FRAME = 24, OPERATION = 8, STEP = 6 };

typedef struct {
    const fmi2CallbackFunctions *functions;
    char name[64];
    double u, y;
    int reached;
    int status; /* that the present call is to return */
} Fmu;

static void nap(double seconds) {
    struct timespec time = {(time_t)seconds, (long)((seconds - (double)(time_t)seconds) * 1e9)};
    nanosleep(&time, NULL);
}

static void sleep_on(void) { for (;;) pause(); }

/* ---- ends */
static void segfault(Fmu *f) { (void)f; *(volatile int *)8 = 1; }
static void do_abort(Fmu *f) { (void)f; abort(); }
static void exit_0(Fmu *f) { (void)f; exit(0); }
static void exit_3(Fmu *f) { (void)f; exit(3); }
static void exit_at_once(Fmu *f) { (void)f; _exit(0); }
static void kill_itself(Fmu *f) { (void)f; kill(getpid(), SIGKILL); sleep_on(); }
static void trap(Fmu *f) { (void)f; __builtin_trap(); }
static void divide(Fmu *f) { volatile int zero = 0; f->reached = 1 / zero; raise(SIGFPE); }
static void free_twice(Fmu *f) {
    (void)f;
    void *volatile piece = malloc(64);
    void *again = piece;
    free(piece);
    free(again);
    abort();
}
static int deeper(volatile char *before) {
    volatile char more[65536];
    more[0] = before[0];
    return deeper(more) + more[0];
}
static void overflow_stack(Fmu *f) { char begin[1] = {0}; f->reached += deeper(begin); }
static void unmap_itself(Fmu *f) {
    (void)f;
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    munmap((void *)((size_t)unmap_itself / page * page), page);
}
static void alarm_clock(Fmu *f) {
    (void)f;
    struct itimerval soon = {{0, 0}, {0, 20000}};
    setitimer(ITIMER_REAL, &soon, NULL);
    sleep_on();
}
static void exec_true(Fmu *f) { (void)f; execl("/bin/true", "true", (char *)NULL); }
static void exec_sleep(Fmu *f) { (void)f; execl("/bin/sleep", "sleep", "1000", (char *)NULL); }

/* ---- hangs */
static void spin(Fmu *f) { (void)f; for (volatile int on = 1; on;) {} }
static void sleep_for_ever(Fmu *f) { (void)f; sleep_on(); }
static void stop_itself(Fmu *f) { (void)f; raise(SIGSTOP); sleep_on(); }
static void deafen(Fmu *f) {
    (void)f;
    sigset_t all;
    sigfillset(&all);
    sigprocmask(SIG_BLOCK, &all, NULL);
    for (int number = 1; number < 32; number++) signal(number, SIG_IGN);
    sleep_on();
}
static void return_to_fault(int number) { (void)number; }
static void fault_for_ever(Fmu *f) {
    signal(SIGSEGV, return_to_fault);
    segfault(f);
}
static void be_traced(Fmu *f) {
    (void)f;
    ptrace(PTRACE_TRACEME, 0, 0, 0);
    raise(SIGTRAP);
    sleep_on();
}
static void read_all(Fmu *f);
static void steal_requests(Fmu *f) {
    if (fork() == 0) {
        setsid();
        for (;;) read_all(f);
    }
}

/* ---- memory */
static void fill(size_t megabytes) {
    for (size_t i = 0; i < megabytes; i++) {
        volatile char *piece = malloc(1 << 20);
        if (piece) for (size_t k = 0; k < 1 << 20; k += 1024) piece[k] = 1;
    }
}
static void grow(Fmu *f) { (void)f; fill(300); sleep_on(); }
static void grow_and_return(Fmu *f) { (void)f; fill(300); nap(0.1); }
static void grow_in_a_child(Fmu *f) {
    (void)f;
    if (fork() == 0) { setsid(); fill(300); sleep_on(); }
    sleep_on();
}
static void grow_in_many_children(Fmu *f) {
    (void)f;
    for (int i = 0; i < 6; i++) if (fork() == 0) { setsid(); fill(60); sleep_on(); }
    sleep_on();
}
static void exhaust_descriptors(Fmu *f) { (void)f; while (open("/dev/null", O_RDONLY) >= 0) {} }
static void grow_without_descriptors(Fmu *f) { exhaust_descriptors(f); grow(f); }
static void grow_shared(Fmu *f) {
    (void)f;
    char *memory = mmap(NULL, 300 << 20, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory != MAP_FAILED) memset(memory, 1, 300 << 20);
    sleep_on();
}
static void demand_much(Fmu *f) {
    void *volatile much = malloc((size_t)1 << 40);
    if (!much) f->status = fmi2Error;
}

/* ---- the channel */
static int is_pipe(int descriptor) {
    struct stat status;
    return fstat(descriptor, &status) == 0 && S_ISFIFO(status.st_mode);
}
static void write_all(const void *content, size_t size) {
    for (int d = 3; d < DESCRIPTORS; d++) if (is_pipe(d)) (void)!write(d, content, size);
}
static void read_all(Fmu *f) {
    (void)f;
    char content[4096];
    for (int d = 3; d < DESCRIPTORS; d++) {
        if (!is_pipe(d)) continue;
        int flags = fcntl(d, F_GETFL);
        fcntl(d, F_SETFL, flags | O_NONBLOCK);
        (void)!read(d, content, sizeof content);
        fcntl(d, F_SETFL, flags);
    }
}
static void close_all(Fmu *f) { (void)f; for (int d = 3; d < DESCRIPTORS; d++) close(d); }
static void close_standard(Fmu *f) { (void)f; for (int d = 0; d < 3; d++) close(d); }
static void close_all_and_sleep(Fmu *f) { close_all(f); sleep_on(); }
static void write_garbage(Fmu *f) { (void)f; write_all("this is no reply, whatever else it may be", 41); }
static void write_half_a_frame(Fmu *f) { (void)f; write_all("\1\0\0\0\0", 5); sleep_on(); }
static void write_drop_by_drop(Fmu *f) {
    (void)f;
    char frame[FRAME] = {0};
    write_all(frame, 3);
    for (;;) { nap(0.01); write_all("", 1); }
}
static void surplus_frame(Fmu *f) {
    (void)f;
    char frame[FRAME] = {0};
    frame[OPERATION] = STEP;
    write_all(frame, sizeof frame);
}
static void frames_to_come(Fmu *f) {
    (void)f;
    char frame[FRAME] = {0};
    frame[OPERATION] = STEP;
    for (frame[0] = 1; frame[0] < 20; frame[0]++) write_all(frame, sizeof frame);
}
static void claim_a_gigabyte(Fmu *f) {
    (void)f;
    char frame[FRAME] = {0};
    memset(frame + 12, 0x7f, 12);
    write_all(frame, sizeof frame);
    sleep_on();
}
static void *flood(void *unused) {
    char frame[FRAME] = {0};
    frame[OPERATION] = STEP;
    for (;;) write_all(frame, sizeof frame);
    return unused;
}
static void flood_from_a_thread(Fmu *f) {
    (void)f;
    pthread_t thread;
    pthread_create(&thread, NULL, flood, NULL);
}
static void flood_from_a_child(Fmu *f) {
    (void)f;
    if (fork() == 0) { setsid(); flood(NULL); }
}
static void shout(Fmu *f) { (void)f; for (int i = 0; i < 100; i++) printf("%s\n", "the FMU shouts"); fflush(stdout); }

/* ---- processes */
static void fork_and_return(Fmu *f) { (void)f; fork(); }
static void fork_and_leave(Fmu *f) { (void)f; if (fork() == 0) return; _exit(0); }
static void child_keeps_the_pipe(Fmu *f) {
    (void)f;
    if (fork() == 0) { setsid(); sleep_on(); }
    _exit(5);
}
static void child_keeps_the_pipe_of_a_hung_one(Fmu *f) {
    (void)f;
    if (fork() == 0) { setsid(); sleep_on(); }
    sleep_on();
}
static void child_stays(Fmu *f) { (void)f; if (fork() == 0) sleep_on(); }
static void daemon_stays(Fmu *f) {
    (void)f;
    pid_t child = fork();
    if (child == 0) {
        setsid();
        if (fork() != 0) _exit(0);
        clearenv();
        signal(SIGTERM, SIG_IGN);
        signal(SIGHUP, SIG_IGN);
        sleep_on();
    }
    waitpid(child, NULL, 0);
}
static void program_stays(Fmu *f) {
    (void)f;
    if (fork() == 0) { setpgid(0, 0); execl("/bin/sleep", "sleep", "1000", (char *)NULL); }
}
static void many_stay(Fmu *f) { (void)f; for (int i = 0; i < 12; i++) if (fork() == 0) { setsid(); sleep_on(); } }
static void comet(Fmu *f) {
    (void)f;
    if (fork() != 0) return;
    for (;;) { setsid(); if (fork() != 0) _exit(0); nap(0.001); }
}
static void kill_parent(Fmu *f) { (void)f; kill(getppid(), SIGKILL); nap(0.1); }
static void terminate_parent(Fmu *f) { (void)f; kill(getppid(), SIGTERM); nap(0.1); }
static void hang_up_on_parent(Fmu *f) { (void)f; kill(getppid(), SIGHUP); nap(0.1); }
static void stop_parent(Fmu *f) { (void)f; kill(getppid(), SIGSTOP); sleep_on(); }
static void orphan_itself(Fmu *f) {
    (void)f;
    prctl(PR_SET_PDEATHSIG, 0);
    nap(0.1);
    kill(getppid(), SIGKILL);
    sleep_on();
}
static void kill_group(Fmu *f) { (void)f; kill(0, SIGKILL); sleep_on(); }
static void adopt(Fmu *f) { prctl(PR_SET_CHILD_SUBREAPER, 1); daemon_stays(f); }
static void *crash_later(void *unused) { nap(0.05); abort(); return unused; }
static void thread_crashes(Fmu *f) {
    (void)f;
    pthread_t thread;
    pthread_create(&thread, NULL, crash_later, NULL);
    nap(0.2);
}
static void *spin_on(void *unused) { for (volatile int on = 1; on;) {} return unused; }
static void thread_spins(Fmu *f) { (void)f; pthread_t thread; pthread_create(&thread, NULL, spin_on, NULL); }

/* ---- files */
static void for_files(void (*act)(const char *)) {
    DIR *folder = opendir(getenv("TMPDIR"));
    if (!folder) return;
    char path[1024];
    for (struct dirent *entry = readdir(folder); entry; entry = readdir(folder)) {
        if (entry->d_name[0] == '.') continue;
        snprintf(path, sizeof path, "%s/%s", getenv("TMPDIR"), entry->d_name);
        act(path);
    }
    closedir(folder);
}
static void empty(const char *path) { (void)!truncate(path, 0); }
static void make_fifo(const char *path) { unlink(path); (void)!mkfifo(path, 0600); }
static void make_link(const char *path) { unlink(path); (void)!symlink("/dev/zero", path); }
static void lock_up(const char *path) { chmod(path, 0); }
static void empty_files(Fmu *f) { (void)f; for_files(empty); }
static void empty_files_and_crash(Fmu *f) { for_files(empty); segfault(f); }
static void put_fifos(Fmu *f) { (void)f; for_files(make_fifo); }
static void put_fifos_and_crash(Fmu *f) { for_files(make_fifo); segfault(f); }
static void put_links_and_crash(Fmu *f) { for_files(make_link); segfault(f); }
static void lock_up_folders(Fmu *f) { (void)f; for_files(lock_up); }

/* ---- the state of the process */
static void round_up(Fmu *f) { (void)f; fesetround(FE_UPWARD); }
static void leave_folder(Fmu *f) { (void)f; (void)!chdir("/"); umask(0777); }
static void take_signals(Fmu *f) {
    (void)f;
    signal(SIGINT, SIG_IGN);
    signal(SIGTERM, SIG_IGN);
}
static void block_signals(Fmu *f) {
    (void)f;
    sigset_t some;
    sigemptyset(&some);
    sigaddset(&some, SIGINT);
    sigaddset(&some, SIGTERM);
    sigprocmask(SIG_BLOCK, &some, NULL);
}
static void speak_otherwise(Fmu *f) { (void)f; setlocale(LC_ALL, "C.UTF-8"); }
static void lower_limits(Fmu *f) {
    (void)f;
    struct rlimit none = {0, 0};
    setrlimit(RLIMIT_NOFILE, &none);
    setrlimit(RLIMIT_FSIZE, &none);
}
static void at_exit_hang(void) { sleep_on(); }
static void hang_at_exit(Fmu *f) { (void)f; atexit(at_exit_hang); }

/* ---- what is told */
static void say(Fmu *f, const char *text, int status) {
    f->functions->logger(f->functions->componentEnvironment, f->name, (fmi2Status)status, "logAll", text);
}
static void log_flood(Fmu *f) { for (int i = 0; i < 20000; i++) say(f, "again and again and again", fmi2OK); }
static void log_nonsense(Fmu *f) {
    say(f, "\xff\xfe\xed\xa0\x80 no UTF-8 \033[2J", 99);
    say(f, NULL, -7);
}
static void log_a_megabyte(Fmu *f) {
    char *text = malloc(1 << 20);
    if (!text) return;
    memset(text, 'x', (1 << 20) - 1);
    text[(1 << 20) - 1] = 0;
    for (int i = 0; i < 3; i++) say(f, text, fmi2Warning);
    free(text);
}
static void illegal_status(Fmu *f) { f->status = 99; }
static void negative_status(Fmu *f) { f->status = -1; }
static void fatal_status(Fmu *f) { f->status = fmi2Fatal; }
static void pending_status(Fmu *f) { f->status = fmi2Pending; }

static const struct { const char *name; void (*act)(Fmu *); } MISDEEDS[] = {
#define MISDEED(name) {#name, name}
    MISDEED(segfault), MISDEED(do_abort), MISDEED(exit_0), MISDEED(exit_3), MISDEED(exit_at_once), MISDEED(kill_itself),
    MISDEED(trap), MISDEED(divide), MISDEED(free_twice), MISDEED(overflow_stack), MISDEED(unmap_itself),
    MISDEED(alarm_clock), MISDEED(exec_true), MISDEED(exec_sleep), MISDEED(spin), MISDEED(sleep_for_ever),
    MISDEED(stop_itself), MISDEED(deafen), MISDEED(fault_for_ever), MISDEED(be_traced), MISDEED(steal_requests),
    MISDEED(grow), MISDEED(grow_and_return), MISDEED(grow_in_a_child), MISDEED(grow_in_many_children),
    MISDEED(exhaust_descriptors), MISDEED(grow_without_descriptors), MISDEED(grow_shared), MISDEED(demand_much),
    MISDEED(close_all), MISDEED(close_standard), MISDEED(close_all_and_sleep), MISDEED(write_garbage),
    MISDEED(write_half_a_frame), MISDEED(write_drop_by_drop), MISDEED(surplus_frame), MISDEED(frames_to_come),
    MISDEED(claim_a_gigabyte), MISDEED(flood_from_a_thread), MISDEED(flood_from_a_child), MISDEED(shout),
    MISDEED(fork_and_return), MISDEED(fork_and_leave), MISDEED(child_keeps_the_pipe),
    MISDEED(child_keeps_the_pipe_of_a_hung_one), MISDEED(child_stays), MISDEED(daemon_stays), MISDEED(program_stays),
    MISDEED(many_stay), MISDEED(comet), MISDEED(kill_parent), MISDEED(terminate_parent), MISDEED(hang_up_on_parent),
    MISDEED(stop_parent), MISDEED(orphan_itself), MISDEED(kill_group), MISDEED(adopt), MISDEED(thread_crashes),
    MISDEED(thread_spins), MISDEED(empty_files), MISDEED(empty_files_and_crash), MISDEED(put_fifos),
    MISDEED(put_fifos_and_crash), MISDEED(put_links_and_crash), MISDEED(lock_up_folders), MISDEED(round_up),
    MISDEED(leave_folder), MISDEED(take_signals), MISDEED(block_signals), MISDEED(speak_otherwise),
    MISDEED(lower_limits), MISDEED(hang_at_exit), MISDEED(log_flood), MISDEED(log_nonsense), MISDEED(log_a_megabyte),
    MISDEED(illegal_status), MISDEED(negative_status), MISDEED(fatal_status), MISDEED(pending_status),
};

static void reach(Fmu *f, const char *place, int times) {
    size_t length = strlen(place);
    if (strncmp(f->name, place, length) != 0 || strncmp(f->name + length, "__", 2) != 0) return;
    if (++f->reached != times) return;
    for (size_t i = 0; i < sizeof MISDEEDS / sizeof *MISDEEDS; i++) {
        if (strcmp(f->name + length + 2, MISDEEDS[i].name) != 0) continue;
        const char *mark = getenv("MISDEED");
        if (mark) close(open(mark, O_CREAT | O_WRONLY, 0600));
        MISDEEDS[i].act(f);
    }
}

static fmi2Status told(Fmu *f) {
    int status = f->status;
    f->status = fmi2OK;
    return (fmi2Status)status;
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    (void)type; (void)guid; (void)resources; (void)visible; (void)logging;
    Fmu *f = calloc(1, sizeof *f);
    f->functions = functions;
    strncpy(f->name, name, sizeof f->name - 1);
    reach(f, "instantiate", 1);
    if (told(f)) { free(f); return NULL; }
    return f;
}
void fmi2FreeInstance(fmi2Component c) {
    reach(c, "free", 1);
    free(c);
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    Fmu *f = c;
    reach(f, "set", 5);
    for (size_t i = 0; i < n; i++) if (vr[i] == VR_U) f->u = value[i];
    return told(f);
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    Fmu *f = c;
    reach(f, "get", 5);
    for (size_t i = 0; i < n; i++) value[i] = vr[i] == VR_Y ? f->y : f->u;
    return told(f);
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real size, fmi2Boolean set_back) {
    Fmu *f = c;
    (void)time; (void)set_back;
    reach(f, "step", 3);
    f->y += f->u * size;
    return told(f);
}

#define ACCEPT(name, ...) fmi2Status name(fmi2Component c, ##__VA_ARGS__) { (void)c; return fmi2OK; }
#define REFUSE(name, ...) fmi2Status name(fmi2Component c, ##__VA_ARGS__) { (void)c; return fmi2Error; }
ACCEPT(fmi2SetupExperiment, fmi2Boolean a, fmi2Real b, fmi2Real d, fmi2Boolean e, fmi2Real g)
ACCEPT(fmi2EnterInitializationMode)
ACCEPT(fmi2ExitInitializationMode)
ACCEPT(fmi2Terminate)
ACCEPT(fmi2Reset)
ACCEPT(fmi2SetDebugLogging, fmi2Boolean on, size_t n, const fmi2String names[])
ACCEPT(fmi2CancelStep)
REFUSE(fmi2SetInteger, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[])
REFUSE(fmi2GetInteger, const fmi2ValueReference vr[], size_t n, fmi2Integer value[])
REFUSE(fmi2SetBoolean, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[])
REFUSE(fmi2GetBoolean, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[])
REFUSE(fmi2SetString, const fmi2ValueReference vr[], size_t n, const fmi2String value[])
REFUSE(fmi2GetString, const fmi2ValueReference vr[], size_t n, fmi2String value[])
REFUSE(fmi2GetFMUstate, fmi2FMUstate *state)
REFUSE(fmi2SetFMUstate, fmi2FMUstate state)
REFUSE(fmi2FreeFMUstate, fmi2FMUstate *state)
REFUSE(fmi2SerializedFMUstateSize, fmi2FMUstate state, size_t *size)
REFUSE(fmi2SerializeFMUstate, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
REFUSE(fmi2DeSerializeFMUstate, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
REFUSE(fmi2GetDirectionalDerivative, const fmi2ValueReference u[], size_t n, const fmi2ValueReference k[], size_t m,
       const fmi2Real seed[], fmi2Real derivative[])
REFUSE(fmi2SetRealInputDerivatives, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
       const fmi2Real value[])
REFUSE(fmi2GetRealOutputDerivatives, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
       fmi2Real value[])
REFUSE(fmi2GetStatus, const fmi2StatusKind kind, fmi2Status *value)
REFUSE(fmi2GetRealStatus, const fmi2StatusKind kind, fmi2Real *value)
REFUSE(fmi2GetIntegerStatus, const fmi2StatusKind kind, fmi2Integer *value)
REFUSE(fmi2GetBooleanStatus, const fmi2StatusKind kind, fmi2Boolean *value)
REFUSE(fmi2GetStringStatus, const fmi2StatusKind kind, fmi2String *value)
