"""Kills commands that write at random moments: files are whole or absent, and a second run gives the same bytes.

    python peers/kills/kills.py LIFELIKE KILLS_PER_COMMAND [SEED]

Run it in the repository's root, with the path of the small program.
"""
import json,os,random,shutil,signal,subprocess,sys,tempfile,time
L=sys.argv[1]; N=int(sys.argv[2]); seed=int(sys.argv[3]) if len(sys.argv)>3 else 1
random.seed(seed); W=tempfile.mkdtemp()
R=os.getcwd()
def run(args,**k): return subprocess.Popen([L,'-q',*args],cwd=R,stdout=subprocess.DEVNULL,stderr=subprocess.PIPE,**k)
# inputs
subprocess.run([L,'-q','motion','retarget','motions/wave.keys.toml','motions/nod.keys.toml','--robot','lima','-o',W+'/in'],cwd=R,stdout=subprocess.DEVNULL)
clips=W+'/in'
cmds={
 'motion retarget':lambda o:['motion','retarget','motions/wave.keys.toml','motions/nod.keys.toml','motions/walk.keys.toml','--robot','lima','--threads','1','-o',o],
 'motion lint --fix':lambda o:['motion','lint',clips,'--fix','-o',o],
 'motion convert':lambda o:['motion','convert',clips,'--fps','100','-o',o],
 'motion convert --to csv':lambda o:['motion','convert',clips,'--to','csv','-o',o],
 'motion repair':lambda o:['motion','repair',clips,'--robot','lima','-o',o],
 'motion mirror':lambda o:['motion','mirror',clips+'/wave.motion.safetensors','-o',o],
 'motion sequence':lambda o:['motion','sequence',clips+'/wave.motion.safetensors',clips+'/nod.motion.safetensors','-o',o],
 'eval':lambda o:['eval','--policy','lima','--motions','builtin:wave','--starts','1','--seconds','1','-o',o],
 'export':lambda o:['export','assets/lima-path.policy.safetensors','--robot','lima','-o',o+'/x.controller.safetensors'],
 'dataset grammar':lambda o:['dataset','grammar','--robot','lima','--hours','0.003','-o',o],
 'dataset captures':lambda o:['dataset','captures',clips,'-o',o],
 'demo':lambda o:['demo','-o',o],
}
def files(o):
    out={}
    for d,_,fs in os.walk(o):
        for f in fs:
            p=os.path.join(d,f); out[os.path.relpath(p,o)]=open(p,'rb').read()
    return out
def whole(name,b):
    if name.endswith('.safetensors'):
        if len(b)<8: return False
        n=int.from_bytes(b[:8],'little')
        try: h=json.loads(b[8:8+n])
        except Exception: return False
        return len(b)==8+n+max(v['data_offsets'][1] for k,v in h.items() if k!='__metadata__')
    if name.endswith('.json'):
        try: json.loads(b); return True
        except Exception: return False
    if name.endswith('.jsonl'): return b.endswith(b'\n') or not b
    if name.endswith('.html'): return b.rstrip().endswith(b'</html>')
    if name.endswith('.csv'): return b.endswith(b'\n')
    return True
total=half=diff=0; per={}
for name,make in cmds.items():
    ref=W+'/ref-'+name.replace(' ','_'); 
    if 'export' in name: os.makedirs(ref,exist_ok=True)
    t=time.time(); p=run(make(ref)); e=p.communicate()[1]; T=time.time()-t
    if p.returncode!=0: print(name,'rc',p.returncode,e[-200:]); continue
    F=files(ref); ref2=W+'/ref2'; shutil.rmtree(ref2,ignore_errors=True)
    if 'export' in name: os.makedirs(ref2,exist_ok=True)
    p=run(make(ref2)); p.communicate(); F2=files(ref2)
    stable={k for k in F if F2.get(k)==F[k]}
    bad=[];k=0
    for i in range(N):
        o=W+'/o'; shutil.rmtree(o,ignore_errors=True)
        if 'export' in name: os.makedirs(o)
        p=run(make(o)); time.sleep(random.uniform(0,T*1.0)); 
        alive=p.poll() is None
        if alive: p.send_signal(signal.SIGKILL); k+=1
        p.communicate()
        for f,b in files(o).items():
            if f.split('/')[-1].startswith('.') : continue
            if f in stable and b!=F[f] or not whole(f,b):
                if f.endswith('.jsonl') and F[f].startswith(b): continue
                bad.append(f)
        a=make(o)
        if name=='dataset grammar' and os.path.isdir(o) and os.listdir(o): a=a+['--resume']
        elif name in('dataset captures',): shutil.rmtree(o,ignore_errors=True)
        p=run(a); e=p.communicate()[1]
        G=files(o)
        if p.returncode!=0: bad.append('again rc %d %s'%(p.returncode,e[-160:]))
        for f in stable:
            if G.get(f)!=F[f]: bad.append('again differs '+f)
    total+=k; per[name]=(k,len(bad)); print(f'{name:26} {T:5.1f} s, {len(F)} files ({len(stable)} same bytes in two runs), kills {k}, bad {len(bad)} {bad[:3]}',flush=True)
print('kills',total,'bad',sum(b for _,b in per.values()))
